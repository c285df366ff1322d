//! The native format `.isopatch`, which holds a spline exactly; described byte by byte in docs/format.md.

mod layout;
mod read;
mod write;

pub use read::{NativeError, read_native};
pub use write::write_native;

use super::Unit;
use crate::spline::TriangularSpline;

/// A spline with the words about where it comes from.
#[derive(Clone, Debug)]
pub struct NativeModel {
    /// The surface.
    pub spline: TriangularSpline,
    /// Where it comes from.
    pub provenance: Provenance,
}

/// Where a surface comes from.
#[derive(Clone, Debug, PartialEq)]
pub struct Provenance {
    /// Program and version that made the surface. Default: this one.
    pub generator: String,
    /// Options it was made with, as JSON text. Default: empty.
    pub options: String,
    /// The formula, or the name of the mesh file. Default: empty.
    pub source: String,
    /// Length of a model unit. Default: millimetre.
    pub unit: Unit,
    /// Frozen diagonal of the base mesh, the unit of relative lengths, in model units. Default: 0, not known.
    pub diagonal: f64,
}

impl Default for Provenance {
    fn default() -> Self {
        Self {
            generator: concat!("isopatch ", env!("CARGO_PKG_VERSION")).to_owned(),
            options: String::new(),
            source: String::new(),
            unit: Unit::Mm,
            diagonal: 0.0,
        }
    }
}

#[cfg(test)]
mod tests;
