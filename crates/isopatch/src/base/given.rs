//! A base mesh whose connectivity is given.

use super::build::{BaseOptions, BaseOutcome, Repair, finish, require_convex_corners};
use super::error::BaseError;
use super::triangle_mesh::TriangleMesh;
use super::validity::validity;
use crate::field::Field;
use crate::geom::Point3;
use crate::mesh::HalfEdgeMesh;

/// The base mesh with the connectivity of the given faces and their vertices projected onto f = 0.
///
/// All faces must be triangles and form a closed manifold near the surface. Faces that are clockwise seen from where
/// f > 0 are all turned around, which is reported. Linear time.
pub fn from_mesh<F: AsRef<[u32]>>(
    field: &dyn Field,
    positions: &[Point3],
    faces: &[F],
    options: &BaseOptions,
) -> Result<BaseOutcome, BaseError> {
    let faces: Vec<[u32; 3]> = faces
        .iter()
        .enumerate()
        .map(|(face, f)| {
            let corners = f.as_ref();
            corners.try_into().map_err(|_| BaseError::NotATriangle { face, corners: corners.len() })
        })
        .collect::<Result<_, _>>()?;
    if let Some(vertex) = positions.iter().position(|p| !p.iter().all(|x| x.is_finite())) {
        return Err(BaseError::NonFiniteVertex { vertex });
    }
    let connectivity = HalfEdgeMesh::from_faces(positions.len(), &faces)?;
    if let Some(h) = connectivity.half_edges().find(|h| connectivity.twin(*h).is_none()) {
        return Err(BaseError::OpenMesh { from: connectivity.origin(h).0, to: connectivity.dest(h).0 });
    }

    let mut mesh = TriangleMesh { positions: positions.to_vec(), faces, clip: None };
    let mut repairs = Vec::new();
    if is_inside_out(field, &mesh) {
        mesh.faces.iter_mut().for_each(|f| f.swap(1, 2));
        repairs.push(Repair {
            what: "orientation reversed".into(),
            place: "all faces of the given base mesh".into(),
            why: "they were clockwise seen from outside".into(),
        });
    }
    let base = finish(field, mesh, &options.remesh.projection)?;
    let violations = validity(&base, &options.limits);
    require_convex_corners(&violations)?;
    Ok(BaseOutcome { base, repairs, violations, certified: false })
}

/// Do the faces, taken together, look against the gradient?
fn is_inside_out(field: &dyn Field, mesh: &TriangleMesh) -> bool {
    let agreement: f64 = mesh
        .faces
        .iter()
        .map(|f| {
            let centre = f.iter().map(|v| mesh.positions[*v as usize]).sum::<Point3>() / 3.0;
            let (_, gradient) = field.gradient(centre);
            mesh.area_vector(*f).dot(&gradient.normalize())
        })
        .filter(|x| x.is_finite())
        .sum();
    agreement < 0.0
}

#[cfg(test)]
#[allow(clippy::unwrap_used, reason = "a test that fails by a panic is a test that fails")]
mod tests {
    use super::*;
    use crate::base::test_fields::{field, unit_sphere};
    use crate::field::Formula;

    /// Vertices and faces of an icosahedron in the unit sphere.
    fn icosahedron() -> (Vec<Point3>, Vec<Vec<u32>>) {
        let base = crate::golden::sphere().base;
        let faces = base.mesh.faces().map(|f| base.mesh.triangle(f).map(|v| v.0).to_vec()).collect();
        (base.positions, faces)
    }

    fn over(field: &Formula, positions: &[Point3], faces: &[Vec<u32>]) -> Result<BaseOutcome, BaseError> {
        from_mesh(field, positions, faces, &BaseOptions::default())
    }

    #[test]
    fn vertices_are_put_on_the_surface_and_faces_are_kept() {
        let (positions, faces) = icosahedron();
        let ellipsoid = field("x^2/1.21 + y^2 + z^2/0.9025 - 1");
        let outcome = over(&ellipsoid, &positions, &faces).unwrap();
        assert_eq!((outcome.repairs, outcome.violations), (vec![], vec![]));
        let base = outcome.base;
        assert!(
            base.mesh
                .faces()
                .zip(&faces)
                .all(|(f, given)| base.mesh.triangle(f).map(|v| v.0)[..] == given[..])
        );
        for (p, n) in base.positions.iter().zip(&base.normals) {
            assert!(ellipsoid.value(*p).abs() < 1e-12, "{p:?}");
            assert!(n.dot(p) > 0.0, "{n:?} at {p:?}");
        }
    }

    #[test]
    fn faces_that_look_inward_are_turned() {
        let (positions, faces) = icosahedron();
        let inward: Vec<Vec<u32>> = faces.iter().map(|f| vec![f[0], f[2], f[1]]).collect();
        let outcome = over(&unit_sphere(), &positions, &inward).unwrap();
        assert_eq!(outcome.repairs.len(), 1);
        assert_eq!(outcome.base.mesh, over(&unit_sphere(), &positions, &faces).unwrap().base.mesh);
        // Where the solid is outside they are right.
        assert_eq!(over(&unit_sphere().negated(), &positions, &inward).unwrap().repairs, []);
    }

    #[test]
    fn unfit_meshes_are_refused_by_their_first_fault() {
        let (positions, faces) = icosahedron();
        let error =
            |positions: &[Point3], faces: &[Vec<u32>]| over(&unit_sphere(), positions, faces).unwrap_err();
        let mut with_quad = faces.clone();
        with_quad[3].push(11);
        assert_eq!(error(&positions, &with_quad), BaseError::NotATriangle { face: 3, corners: 4 });
        let mut with_nan = positions.clone();
        with_nan[5].y = f64::NAN;
        assert_eq!(error(&with_nan, &faces), BaseError::NonFiniteVertex { vertex: 5 });
        match error(&positions, &faces[..19]) {
            BaseError::OpenMesh { from, to } => {
                assert!(faces[19].contains(&from) && faces[19].contains(&to), "{from} {to}");
            }
            other => assert_eq!(other.to_string(), "an open mesh"),
        }
        let mut central = positions.clone();
        central[0] = Point3::zeros();
        assert_eq!(error(&central, &faces), BaseError::NotOnSurface { at: Point3::zeros() });
    }
}
