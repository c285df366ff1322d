//! Files: mesh readers.

pub mod read;
