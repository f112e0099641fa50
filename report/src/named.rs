//! Enumerations whose variants have names.

/// An enumeration with a name for each variant: in JSON, in tables and in messages; and, if a
/// function for them is named, other words.
#[macro_export]
macro_rules! named {
    ($(#[$attribute:meta])* pub enum $type:ident {
        $($(#[$about:meta])* $variant:ident = $name:literal, $words:literal;)*
    }
    $(#[$said:meta])* $visible:vis fn $function:ident) => {
        $crate::named::named! {
            $(#[$attribute])*
            pub enum $type {
                $($(#[$about])* $variant = $name,)*
            }
        }

        impl $type {
            $(#[$said])*
            $visible fn $function(self) -> &'static str {
                match self {
                    $(Self::$variant => $words,)*
                }
            }
        }
    };
    ($(#[$attribute:meta])* pub enum $type:ident {
        $($(#[$about:meta])* $variant:ident = $name:literal,)*
    }) => {
        $(#[$attribute])*
        #[derive(Clone, Copy, Debug, PartialEq, Eq, serde::Serialize, serde::Deserialize)]
        pub enum $type {
            $($(#[$about])* #[serde(rename = $name)] $variant,)*
        }

        impl $type {
            /// All of them.
            pub const ALL: [Self; [$($name),*].len()] = [$(Self::$variant),*];

            /// Its name.
            pub const fn name(self) -> &'static str {
                match self {
                    $(Self::$variant => $name,)*
                }
            }
        }
    };
}
pub use named;
