//! Every example runs, and what it asserts holds.

/// Runs each example, a module with a `main`.
macro_rules! examples {
    ($($name:ident: $path:literal;)*) => {
        $(
            #[path = $path]
            mod $name;

            #[test]
            fn $name() {
                $name::main().unwrap();
            }
        )*
    };
}

examples! {
    first_run: "../examples/first_run.rs";
    own_chain: "../examples/own_chain.rs";
    contacts: "../examples/contacts.rs";
    order_study: "../examples/order_study.rs";
    dark_breather: "../examples/dark_breather.rs";
    continuation: "../examples/continuation.rs";
    sweep: "../examples/sweep.rs";
    arenstorf: "../integrators/examples/arenstorf.rs";
    bouncing_ball: "../integrators/examples/bouncing_ball.rs";
    own_method: "../integrators/examples/own_method.rs";
    own_hamiltonian: "../integrators/examples/own_hamiltonian.rs";
    own_law: "../integrators/examples/own_law.rs";
}
