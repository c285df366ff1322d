//! What the integration tests share.

#![allow(clippy::unwrap_used, clippy::panic)] // These are tests.

pub mod golden;
pub mod python;
