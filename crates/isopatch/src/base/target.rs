//! A field as what a surface is fitted to.

use super::project::{ProjectOptions, project_points};
use crate::field::Field;
use crate::geom::{Points, PointsMut, PointsView};
use crate::surface::Target;

/// The zero set of a field as a [`Target`].
pub struct FieldTarget<'a> {
    field: &'a dyn Field,
    diagonal: f64,
    projection: ProjectOptions,
}

/// Samples of a fit stop at steps this long, as a share of the diagonal. The step is still taken, and Newton's
/// iteration converges quadratically, so that what remains is far below rounding.
const FIT_TOLERANCE: f64 = 1e-9;

impl<'a> FieldTarget<'a> {
    /// The zero set of `field`, with lengths measured by `diagonal`.
    pub fn new(field: &'a dyn Field, diagonal: f64) -> Self {
        let projection = ProjectOptions { tolerance: FIT_TOLERANCE, ..ProjectOptions::default() };
        Self { field, diagonal, projection }
    }
}

impl Target for FieldTarget<'_> {
    fn project(&self, points: &mut Points) {
        // Points that do not arrive stay where |f| was smallest, which is the best sample there is.
        project_points(self.field, points, self.diagonal, &self.projection);
    }

    fn offsets(&self, points: PointsView<'_>, offset: &mut [f64], mut normal: PointsMut<'_>) {
        self.field.gradients(points, offset, normal.reborrow());
        for i in 0..offset.len() {
            let (x, y, z) = (&mut normal.x[i], &mut normal.y[i], &mut normal.z[i]);
            let scale = 1.0 / (*x * *x + *y * *y + *z * *z).sqrt();
            (*x, *y, *z) = (*x * scale, *y * scale, *z * scale);
            offset[i] *= scale;
        }
    }
}
