//! A polygon mesh as a tessellation, to be drawn as it is.

use crate::geom::{Point3, Vec3, angle_between};
use crate::surface::PatchId;
use crate::tessellate::Tessellation;
use std::collections::HashMap;

/// Faces at a larger angle meet in a crease, in radians: 40°.
const CREASE: f64 = 40.0 * std::f64::consts::PI / 180.0;

/// Every polygon becomes a patch, cut into triangles from its first corner.
///
/// Vertices at the same place become one. The normals are those of the vertices if there are any, else at each corner the mean of
/// the faces around, weighted by their angles, that are within 40° of the corner's own. `faces` are numbers of positions; faces
/// with others, or with fewer than three corners, are left out.
pub fn of_polygons<F: AsRef<[u32]>>(
    positions: &[Point3],
    faces: &[F],
    normals: Option<&[Vec3]>,
) -> Tessellation {
    let (first_at, positions) = welded(positions);
    let mut mesh = Tessellation {
        positions,
        normals: Vec::new(),
        triangles: Vec::new(),
        corner_normals: Vec::new(),
        patches: Vec::new(),
    };
    let valid = |face: &&F| {
        let corners = face.as_ref();
        corners.len() >= 3 && corners.iter().all(|v| (*v as usize) < first_at.len())
    };
    let faces: Vec<&[u32]> = faces.iter().filter(valid).map(AsRef::as_ref).collect();
    for (patch, face) in faces.iter().enumerate() {
        for pair in face[1..].windows(2) {
            let corners = [face[0], pair[0], pair[1]];
            mesh.triangles.push(corners.map(|v| first_at[v as usize]));
            mesh.corner_normals.push(corners);
            mesh.patches.push(PatchId(patch as u32));
        }
    }
    match normals.filter(|normals| normals.len() == first_at.len()) {
        Some(normals) => {
            mesh.normals = normals.iter().map(|n| n.try_normalize(0.0).unwrap_or_default()).collect()
        }
        None => (mesh.normals, mesh.corner_normals) = estimated(&mesh),
    }
    mesh
}

/// The number of each position among those that differ, and these.
fn welded(positions: &[Point3]) -> (Vec<u32>, Vec<Point3>) {
    let mut numbers = HashMap::with_capacity(positions.len());
    let mut distinct = Vec::new();
    let number_of = positions
        .iter()
        .map(|p| {
            // Adding zero makes −0 the same as 0.
            let key: [u64; 3] = std::array::from_fn(|c| (p[c] + 0.0).to_bits());
            *numbers.entry(key).or_insert_with(|| {
                distinct.push(*p);
                distinct.len() as u32 - 1
            })
        })
        .collect();
    (number_of, distinct)
}

/// A normal for each corner of each triangle.
fn estimated(mesh: &Tessellation) -> (Vec<Vec3>, Vec<[u32; 3]>) {
    let corner = |t: usize| mesh.triangles[t].map(|v| mesh.positions[v as usize]);
    let face_normals: Vec<Vec3> = (0..mesh.triangles.len())
        .map(|t| {
            let [a, b, c] = corner(t);
            (b - a).cross(&(c - a)).try_normalize(0.0).unwrap_or_default()
        })
        .collect();
    // The triangles at each vertex with their angles there.
    let mut around = vec![Vec::new(); mesh.positions.len()];
    for (t, triangle) in mesh.triangles.iter().enumerate() {
        let p = corner(t);
        for k in 0..3 {
            let angle = angle_between(&(p[(k + 1) % 3] - p[k]), &(p[(k + 2) % 3] - p[k]));
            around[triangle[k] as usize].push((t, angle));
        }
    }
    let mut normals = Vec::with_capacity(3 * mesh.triangles.len());
    let mut numbers = Vec::with_capacity(mesh.triangles.len());
    for (t, triangle) in mesh.triangles.iter().enumerate() {
        let own = face_normals[t];
        numbers.push([0, 1, 2].map(|k| normals.len() as u32 + k));
        for v in triangle {
            let near =
                around[*v as usize].iter().filter(|(s, _)| angle_between(&face_normals[*s], &own) < CREASE);
            let sum: Vec3 = near.map(|(s, angle)| *angle * face_normals[*s]).sum();
            normals.push(sum.try_normalize(0.0).unwrap_or(own));
        }
    }
    (normals, numbers)
}

#[cfg(test)]
mod tests {
    use super::super::Borders;
    use super::*;

    #[test]
    fn a_cube_has_twelve_creases_and_six_patches() {
        let positions: Vec<Point3> =
            crate::geom::Aabb::new(Point3::zeros(), Point3::repeat(1.0)).corners().to_vec();
        let faces = [[0u32, 2, 3, 1], [4, 5, 7, 6], [0, 1, 5, 4], [2, 6, 7, 3], [0, 4, 6, 2], [1, 3, 7, 5]];
        // As in STL files: every face has its own vertices.
        let apart: Vec<Point3> = faces.iter().flatten().map(|v| positions[*v as usize]).collect();
        let faces_apart: Vec<[u32; 4]> = (0..6).map(|f| [0, 1, 2, 3].map(|k| 4 * f + k)).collect();
        for mesh in [of_polygons(&positions, &faces, None), of_polygons(&apart, &faces_apart, None)] {
            let borders = Borders::new(&mesh);
            assert_eq!((mesh.positions.len(), mesh.triangles.len()), (8, 12));
            assert_eq!((borders.creases.len(), borders.seams.len(), borders.boundary.len()), (12, 12, 0));
            assert!(mesh.normals.iter().all(|n| n.amax() > 1.0 - 1e-12));
        }
    }

    #[test]
    fn faces_that_are_none_are_left_out() {
        let positions = [Point3::zeros(), Point3::x(), Point3::y()];
        let faces: [&[u32]; 3] = [&[0, 1], &[0, 1, 7], &[0, 1, 2]];
        let mesh = of_polygons(&positions, &faces, Some(&[Vec3::z(); 3]));
        assert_eq!((mesh.triangles.len(), mesh.normals.len()), (1, 3));
    }
}
