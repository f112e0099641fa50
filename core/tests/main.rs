//! Tests of the package against its public interface.

mod parts;
