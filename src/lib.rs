//! hertzchain
