//! The six surfaces of Tong & Kim 2009 as compiled functions: what peers sample, and what every result is measured against.

pub mod c_interface;
pub mod newton;
pub mod number;
pub mod samples;
pub mod shape;
pub mod surface;
