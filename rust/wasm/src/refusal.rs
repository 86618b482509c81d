//! Why nothing was done.

/// Whatever is refused, as a message for a person.
pub(crate) type Refusal = Box<dyn std::error::Error>;
