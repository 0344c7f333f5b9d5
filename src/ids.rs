//! Typed indices. A vector indexed by one of these says so in its doc comment.

macro_rules! id {
    ($(#[$doc:meta])* $name:ident) => {
        $(#[$doc])*
        #[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash, serde::Serialize, serde::Deserialize, schemars::JsonSchema)]
        #[serde(transparent)]
        pub struct $name(pub u32);
        impl $name {
            /// The position in a vector indexed by this id.
            pub fn index(self) -> usize {
                self.0 as usize
            }
        }
    };
}

id!(
    /// A node of the graph.
    NodeId
);
id!(
    /// A strut of the graph.
    StrutId
);
