//! Normals of the sheets at the corners of triangles.

use crate::field::Field;
use crate::geom::{Point3, Vec3};

use super::singular_mesh::{SingularMesh, VertexKind};

/// Where the limit of a normal at a singular corner is looked for, as shares of the way to the middle of the triangle.
const TOWARDS: [f64; 2] = [0.02, 0.04];

/// Newton steps onto the surface.
const STEPS: usize = 12;

/// Sets the normals at all corners: ∇f at regular vertices; at singular ones the limit on the way into the triangle.
pub(super) fn set_normals(field: &dyn Field, mesh: &mut SingularMesh) {
    let normals = mesh.triangles.iter().map(|t| {
        let p = t.map(|v| mesh.positions[v as usize]);
        let flat = (p[1] - p[0]).cross(&(p[2] - p[0]));
        [0, 1, 2].map(|k| {
            let found = match mesh.vertices[t[k] as usize] {
                VertexKind::Regular => field.gradient(p[k]).1.try_normalize(0.0),
                _ => limit(field, p[k], (p[0] + p[1] + p[2]) / 3.0, flat),
            };
            found.or(flat.try_normalize(0.0)).unwrap_or_else(Vec3::z)
        })
    });
    mesh.normals = normals.collect();
}

/// The normal of the surface near `middle` on the way to the singular point `p`, extrapolated; on the side of `flat`.
fn limit(field: &dyn Field, p: Point3, middle: Point3, flat: Vec3) -> Option<Vec3> {
    let direction = flat.try_normalize(0.0)?;
    let at = |share: f64| {
        let start = p + (middle - p) * share;
        let q = onto_sheet(field, start, direction);
        field.gradient(q).1.try_normalize(0.0).map(|n| if n.dot(&direction) < 0.0 { -n } else { n })
    };
    let [near, far] = TOWARDS.map(at);
    let (near, far) = (near?, far?);
    let extrapolated = (near * 2.0 - far).try_normalize(f64::EPSILON);
    extrapolated.filter(|n| n.dot(&direction) > 0.0).or(Some(near))
}

/// A point of the surface on the line through `start` along `direction`; the start if the search leads away.
fn onto_sheet(field: &dyn Field, start: Point3, direction: Vec3) -> Point3 {
    let mut p = start;
    for _ in 0..STEPS {
        let (f, gradient) = field.gradient(p);
        let slope = gradient.dot(&direction);
        if slope == 0.0 || !f.is_finite() {
            break;
        }
        p -= direction * (f / slope);
    }
    if (p - start).iter().all(|c| c.is_finite()) { p } else { start }
}
