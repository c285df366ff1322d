use super::WriteError;
use crate::bernstein::index;
use crate::geom::Point3;
use crate::surface::{PatchForm, PatchId, Surface};

/// Degree of the patches that STEP and VTK files hold.
pub const DEGREE: usize = 7;

/// Control points of a degree-7 triangle.
pub type Net = [Point3; index::count(DEGREE)];

/// The control nets of all patches, checked for what `format` can hold.
pub fn nets<'a>(surface: &'a dyn Surface, format: &'static str) -> Result<Vec<&'a Net>, WriteError> {
    surface.patches().map(|p| net(surface, p, format)).collect()
}

fn net<'a>(surface: &'a dyn Surface, patch: PatchId, format: &'static str) -> Result<&'a Net, WriteError> {
    let PatchForm::BezierTriangle { degree, net } = surface.form(patch) else {
        return Err(WriteError::NoNet { format, patch: patch.0 });
    };
    let wrong = WriteError::Degree { format, patch: patch.0, degree };
    if degree != DEGREE {
        return Err(wrong);
    }
    if !net.iter().all(|p| p.iter().all(|c| c.is_finite())) {
        return Err(WriteError::NotFinite { what: "patch", index: patch.index() });
    }
    net.try_into().map_err(|_| wrong)
}
