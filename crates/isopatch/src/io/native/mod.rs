//! The native format `.isopatch`, which holds a surface exactly; described byte by byte in docs/format.md.

mod layout;
mod read;
mod read_a_patches;
mod read_hybrid;
mod read_rational;
mod write;
mod write_a_patches;
mod write_hybrid;
mod write_rational;

pub use read::{NativeError, read_native};
pub use write::write_native;
pub use write_a_patches::write_native_a_patches;
pub use write_hybrid::write_native_hybrid;
pub use write_rational::write_native_rational;

use super::{Unit, WriteError};
use crate::apatch::APatchSurface;
use crate::hybrid::HybridSurface;
use crate::rational::RationalSurface;
use crate::spline::TriangularSpline;
use crate::surface::Surface;
use std::io::Write;

/// A surface with the words about where it comes from.
#[derive(Debug)]
pub struct NativeModel {
    /// The surface.
    pub surface: NativeSurface,
    /// Where it comes from.
    pub provenance: Provenance,
}

/// A surface that the format can hold.
#[derive(Debug)]
pub enum NativeSurface {
    /// Bézier triangles of degree 7.
    Spline(Box<TriangularSpline>),
    /// Rational A-patches.
    APatches(Box<APatchSurface>),
    /// Hybrid A-patches over polygons.
    Hybrid(Box<HybridSurface>),
    /// Rational patches.
    Rational(Box<RationalSurface>),
}

impl NativeModel {
    /// The surface, if it is a spline.
    pub fn spline(&self) -> Option<&TriangularSpline> {
        match &self.surface {
            NativeSurface::Spline(spline) => Some(spline.as_ref()),
            NativeSurface::APatches(_) | NativeSurface::Hybrid(_) | NativeSurface::Rational(_) => None,
        }
    }

    /// The surface, if it is one of A-patches.
    pub fn a_patches(&self) -> Option<&APatchSurface> {
        match &self.surface {
            NativeSurface::Spline(_) | NativeSurface::Hybrid(_) | NativeSurface::Rational(_) => None,
            NativeSurface::APatches(surface) => Some(surface.as_ref()),
        }
    }

    /// The surface, if it is one of rational patches.
    pub fn rational(&self) -> Option<&RationalSurface> {
        match &self.surface {
            NativeSurface::Spline(_) | NativeSurface::APatches(_) | NativeSurface::Hybrid(_) => None,
            NativeSurface::Rational(surface) => Some(surface.as_ref()),
        }
    }

    /// The surface, whatever its patches are.
    pub fn as_surface(&self) -> &dyn Surface {
        match &self.surface {
            NativeSurface::Spline(spline) => spline.as_ref(),
            NativeSurface::APatches(surface) => surface.as_ref(),
            NativeSurface::Hybrid(surface) => surface.as_ref(),
            NativeSurface::Rational(surface) => surface.as_ref(),
        }
    }

    /// Writes the model so that [`read_native`] gives it back bit for bit.
    ///
    /// # Errors
    /// See [`write_native`], [`write_native_a_patches`], [`write_native_hybrid`] and [`write_native_rational`].
    pub fn write(&self, out: &mut impl Write) -> Result<(), WriteError> {
        match &self.surface {
            NativeSurface::Spline(spline) => write_native(spline, &self.provenance, out),
            NativeSurface::APatches(surface) => write_native_a_patches(surface, &self.provenance, out),
            NativeSurface::Hybrid(surface) => write_native_hybrid(surface, &self.provenance, out),
            NativeSurface::Rational(surface) => write_native_rational(surface, &self.provenance, out),
        }
    }
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
mod a_patch_tests;
#[cfg(test)]
mod tests;
