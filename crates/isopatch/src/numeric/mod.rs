//! Small numerical tools that the methods share.

pub mod quadrature;
