use crate::bernstein::lanes::{TangentsMut, TriangleGrid};
use crate::geom::{Point3, Points, PointsMut, Vec3};
use crate::surface::{PatchForm, PatchId, Sample, Surface};

/// Parameters that are the same in many triangular patches.
pub(super) struct Places {
    parameters: Vec<[f64; 2]>,
    /// For patches of one degree.
    grid: TriangleGrid,
}

/// Memory for what is found in a patch.
#[derive(Default)]
pub(super) struct Room {
    points: Points,
    normals: Points,
    samples: Vec<Sample>,
}

impl Room {
    /// Points and normals that are computed by coordinates.
    pub fn by_axis(
        &mut self,
        points: &mut [Point3],
        normals: &mut [Vec3],
        compute: impl FnOnce(PointsMut<'_>, PointsMut<'_>),
    ) {
        self.points.resize(points.len());
        self.normals.resize(points.len());
        compute(self.points.view_mut(), self.normals.view_mut());
        points.iter_mut().enumerate().for_each(|(i, p)| *p = self.points.get(i));
        normals.iter_mut().enumerate().for_each(|(i, n)| *n = self.normals.get(i));
    }
}

impl Places {
    /// At barycentric parameters; fastest for Bézier triangles of degree `degree`.
    pub fn new(degree: usize, barycentric: &[[f64; 3]]) -> Self {
        let parameters = barycentric.iter().map(|[u, v, _]| [*u, *v]).collect();
        Self { parameters, grid: TriangleGrid::new(degree, barycentric) }
    }

    /// Points and unit normals of a patch; the outputs have as many entries as there are parameters.
    pub fn sample(
        &self,
        surface: &dyn Surface,
        patch: PatchId,
        room: &mut Room,
        points: &mut [Point3],
        normals: &mut [Vec3],
    ) {
        match surface.form(patch) {
            PatchForm::BezierTriangle { degree, net } if degree == self.grid.degree() => {
                room.by_axis(points, normals, |points, normals| {
                    let out = TangentsMut { points, derivatives: None, normals: Some(normals) };
                    self.grid.evaluate(net, out);
                });
            }
            PatchForm::BezierTriangle { .. } | PatchForm::RationalTriangle { .. } | PatchForm::APatch => {
                let zero = Vec3::zeros();
                let nothing = Sample { point: zero, normal: zero, du: zero, dv: zero };
                room.samples.resize(points.len(), nothing);
                surface.sample_batch(patch, &self.parameters, &mut room.samples);
                points.iter_mut().zip(&room.samples).for_each(|(p, sample)| *p = sample.point);
                normals.iter_mut().zip(&room.samples).for_each(|(n, sample)| *n = sample.normal);
            }
        }
    }
}
