//! spline
