use crate::apatch::APatchSurface;
use crate::geom::Vec3;
use crate::mesh::{EdgeId, FaceId, HalfEdgeId};
use crate::surface::PatchId;

/// Adds the normals on the other sides of creases, and gives the numbers of the normals at the corners of each triangle; none if
/// there are no creases.
///
/// Every point has a normal with its own number already: a vertex that of its first corner, a crease that on its left.
pub(super) fn number(
    surface: &APatchSurface,
    n: usize,
    triangles: &[[u32; 3]],
    patches: &[PatchId],
    normals: &mut Vec<Vec3>,
) -> Vec<[u32; 3]> {
    let data = surface.function().hull().data();
    let mesh = data.mesh();
    if !mesh.edges().any(|e| data.is_crease(e)) {
        return Vec::new();
    }
    let of_corners = corner_numbers(surface, normals);
    let of_edges = right_numbers(surface, n, normals);
    let small = super::triangles::small_triangles(n);
    let of_faces = mesh.faces().flat_map(|f| {
        let (small, of_corners, of_edges) = (&small, &of_corners, &of_edges);
        let local = move |t: usize, c: usize| {
            let ijk = small[t][c];
            let point = triangles[f.index() * small.len() + t][c];
            on_face(surface, f, ijk, of_corners, of_edges).unwrap_or(point)
        };
        (0..small.len()).map(move |t| [0, 1, 2].map(|c| local(t, c)))
    });
    let first = mesh.face_count() * small.len();
    let of_squares = triangles[first..].iter().zip(&patches[first..]).map(|(triangle, patch)| {
        let e = surface.square_edges()[patch.index() - mesh.face_count()];
        let h = mesh.edge_half_edge(e);
        let ends = [h, mesh.next(h)];
        triangle.map(|point| {
            let end = ends.iter().find(|h| mesh.origin(**h).0 == point);
            end.map_or(point, |h| of_corners[h.index()])
        })
    });
    of_faces.chain(of_squares).collect()
}

/// The number of the normal of each corner, at the origin of each half edge.
fn corner_numbers(surface: &APatchSurface, normals: &mut Vec<Vec3>) -> Vec<u32> {
    let data = surface.function().hull().data();
    let mesh = data.mesh();
    let mut numbers: Vec<u32> = mesh.half_edges().map(|h| mesh.origin(h).0).collect();
    let cut = |h: HalfEdgeId| data.is_crease(mesh.edge(h));
    for v in mesh.vertices().filter(|v| mesh.ring(*v).any(cut)) {
        let first = mesh.ring(v).next();
        for sector in data.sectors(v) {
            if sector.iter().any(|h| Some(*h) == first) {
                continue;
            }
            let number = normals.len() as u32;
            normals.push(sector.first().map_or_else(Vec3::z, |h| data.gradient(*h).normalize()));
            sector.iter().for_each(|h| numbers[h.index()] = number);
        }
    }
    numbers
}

/// The number of the first normal on the right of each crease, from its start to its end.
fn right_numbers(surface: &APatchSurface, n: usize, normals: &mut Vec<Vec3>) -> Vec<Option<u32>> {
    let function = surface.function();
    let (data, mesh) = (function.hull().data(), function.hull().data().mesh());
    let mut numbers = vec![None; mesh.edge_count()];
    for e in mesh.edges().filter(|e| data.is_crease(*e)) {
        let Some([_, g]) = data.pair(e) else { continue };
        let Some(face) = function.creased_face(mesh.face(g)) else { continue };
        numbers[e.index()] = Some(normals.len() as u32);
        let k = mesh.side(g);
        normals.extend((1..n).map(|i| {
            let mut x = [0.0; 3];
            (x[k], x[(k + 1) % 3]) = (i as f64 / n as f64, (n - i) as f64 / n as f64);
            face.sample(x).map_or_else(|| Vec3::repeat(f64::NAN), |sample| sample.normal)
        }));
    }
    numbers
}

/// The number of the normal of a face at a lattice point, where that is not the number of the point.
fn on_face(
    surface: &APatchSurface,
    f: FaceId,
    ijk: [usize; 3],
    of_corners: &[u32],
    of_edges: &[Option<u32>],
) -> Option<u32> {
    let mesh = surface.function().hull().data().mesh();
    let half_edge = |k: usize| HalfEdgeId(3 * f.0 + k as u32);
    if let Some(corner) = (0..3).find(|c| ijk[(c + 1) % 3] == 0 && ijk[(c + 2) % 3] == 0) {
        return Some(of_corners[half_edge(corner).index()]);
    }
    let third = (0..3).find(|c| ijk[*c] == 0)?;
    let k = (third + 1) % 3;
    let h = half_edge(k);
    let e: EdgeId = mesh.edge(h);
    let first = of_edges[e.index()].filter(|_| mesh.edge_half_edge(e) != h)?;
    // The weight of the corner where h starts is that of the end of the edge.
    Some(first + ijk[k] as u32 - 1)
}
