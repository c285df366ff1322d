//! A base mesh whose connectivity is given.

use super::build::{BaseOptions, BaseOutcome, Repair, finish, require_convex_corners};
use super::error::BaseError;
use super::polygonize::TriangleMesh;
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

    let mut mesh = TriangleMesh { positions: positions.to_vec(), faces };
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
    Ok(BaseOutcome { base, repairs, violations })
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
