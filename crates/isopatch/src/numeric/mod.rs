//! Small numerical tools that the methods share.

pub mod least_distance;
pub mod quadrature;
