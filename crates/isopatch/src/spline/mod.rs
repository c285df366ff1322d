//! G1 splines of degree-7 Bézier triangles (Tong & Kim 2009).

mod surface;

pub use surface::TriangularSpline;
