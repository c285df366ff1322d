//! bernstein
