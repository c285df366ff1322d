//! Unit normals at the vertices of a mesh, from the positions alone.

use super::creases::sectors;
use super::{FaceId, HalfEdgeId, HalfEdgeMesh, VertexId};
use crate::geom::{Point3, Vec3, angle_between};
use std::f64::consts::{PI, TAU};

/// Weighted sum of face normals, each face with the weight of its corner at the vertex.
fn weighted(mesh: &HalfEdgeMesh, positions: &[Point3], weight: impl Fn(&Vec3, &Vec3) -> f64) -> Vec<Vec3> {
    let mut sums = vec![Vec3::zeros(); mesh.vertex_count()];
    for f in mesh.faces() {
        for h in mesh.face_half_edges(f) {
            let [a, b] = sides_at(mesh, positions, h);
            // A face without area has no normal to give.
            if let Some(normal) = normal_seen_at(mesh, positions, h) {
                sums[mesh.origin(h).index()] += weight(&a, &b) * normal;
            }
        }
    }
    sums.into_iter().map(|sum| sum.try_normalize(0.0).unwrap_or_else(Vec3::zeros)).collect()
}

/// The two edges of a face at the corner where a half edge starts, both from that corner.
fn sides_at(mesh: &HalfEdgeMesh, positions: &[Point3], h: HalfEdgeId) -> [Vec3; 2] {
    let at = |v: VertexId| positions[v.index()];
    let p = at(mesh.origin(h));
    [at(mesh.dest(h)) - p, at(mesh.origin(mesh.prev(h))) - p]
}

/// Unit normal of the face at a corner: of a triangle from the edges that meet there, of a larger polygon its mean normal. None
/// without an area.
fn normal_seen_at(mesh: &HalfEdgeMesh, positions: &[Point3], h: HalfEdgeId) -> Option<Vec3> {
    let f = mesh.face(h);
    if mesh.face_half_edges(f).len() > 3 {
        return area_vector(mesh, positions, f).try_normalize(0.0);
    }
    let [a, b] = sides_at(mesh, positions, h);
    a.cross(&b).try_normalize(0.0)
}

/// Area of a face times its mean unit normal: half the sum of p_k × p_k+1 (Newell). It does not depend on the choice of a centre
/// when the polygon is not planar.
pub fn area_vector(mesh: &HalfEdgeMesh, positions: &[Point3], f: FaceId) -> Vec3 {
    let mut corners = mesh.face_vertices(f).map(|v| positions[v.index()]);
    // Relative to the first corner, so that a face far from the origin loses nothing.
    let Some(first) = corners.next() else { return Vec3::zeros() };
    let spokes: Vec<Vec3> = corners.map(|p| p - first).collect();
    0.5 * spokes.windows(2).map(|pair| pair[0].cross(&pair[1])).sum::<Vec3>()
}

/// Mean of the normals of the faces around each vertex, weighted by their angles there; zero where that vanishes.
///
/// Thürmer & Wüthrich, Computing vertex normals from polygonal facets, 1998. Does not depend on how flat parts are cut
/// into triangles.
pub fn angle_weighted(mesh: &HalfEdgeMesh, positions: &[Point3]) -> Vec<Vec3> {
    weighted(mesh, positions, angle_between)
}

/// Mean of the normals of the faces around each vertex, weighted by their areas; zero where that vanishes.
pub fn area_weighted(mesh: &HalfEdgeMesh, positions: &[Point3]) -> Vec<Vec3> {
    weighted(mesh, positions, |a, b| a.cross(b).norm())
}

/// Mean of the area vectors of the faces around each vertex, each divided by the squares of both sides that meet there;
/// zero where it vanishes.
///
/// Max, Weights for computing vertex normals from facet normals, 1999. Exact where a closed ring lies on a sphere with
/// the vertex.
pub fn sphere_exact(mesh: &HalfEdgeMesh, positions: &[Point3]) -> Vec<Vec3> {
    weighted(mesh, positions, |a, b| a.cross(b).norm() / (a.norm_squared() * b.norm_squared()))
}

/// Normals of the limit of Loop subdivision, by the tangent masks at the vertices and at the boundary.
///
/// The choice of Xu, Huang & Bajaj 2001. Where the two tangents are parallel, and where the result points against the
/// faces at a boundary, the angle-weighted normal is taken, or its side.
pub fn loop_limit(mesh: &HalfEdgeMesh, positions: &[Point3]) -> Vec<Vec3> {
    let outward = angle_weighted(mesh, positions);
    mesh.vertices()
        .map(|v| {
            let outward = outward[v.index()];
            let Some(normal) = loop_normal(mesh, positions, v) else { return outward };
            // The boundary masks give a direction up to its sign.
            if mesh.is_boundary_vertex(v) && normal.dot(&outward) < 0.0 { -normal } else { normal }
        })
        .collect()
}

/// Cross product of the two tangents of the Loop limit.
fn loop_normal(mesh: &HalfEdgeMesh, positions: &[Point3], v: VertexId) -> Option<Vec3> {
    let corners: Vec<HalfEdgeId> = mesh.ring(v).collect();
    let boundary = mesh.is_boundary_vertex(v);
    let ring = ring_points(mesh, positions, &corners, boundary);
    let [first, second] = if boundary { boundary_tangents(&ring) } else { smooth_tangents(&ring) };
    first.cross(&second).try_normalize(0.0)
}

/// The far ends of the edges at a run of corners, relative to their vertex: masks have weights that sum to zero. An open run has
/// one more edge than corners.
fn ring_points(mesh: &HalfEdgeMesh, positions: &[Point3], corners: &[HalfEdgeId], open: bool) -> Vec<Vec3> {
    let at = |v: VertexId| positions[v.index()];
    let mut points: Vec<Vec3> = corners.iter().map(|h| at(mesh.dest(*h)) - at(mesh.origin(*h))).collect();
    if let Some(last) = corners.last().filter(|_| open) {
        points.push(at(mesh.origin(mesh.prev(*last))) - at(mesh.origin(*last)));
    }
    points
}

/// Tangents of the Loop limit inside the surface.
fn smooth_tangents(ring: &[Vec3]) -> [Vec3; 2] {
    let n = ring.len() as f64;
    let (mut first, mut second) = (Vec3::zeros(), Vec3::zeros());
    for (i, p) in ring.iter().enumerate() {
        let (sin, cos) = (TAU * i as f64 / n).sin_cos();
        first += cos * p;
        second += sin * p;
    }
    [first, second]
}

/// Tangents of the Loop limit along and across a boundary or a crease, for two points or more.
fn boundary_tangents(ring: &[Vec3]) -> [Vec3; 2] {
    let n = ring.len();
    let second = match n {
        2 => ring[0] + ring[1],
        3 => ring[1],
        _ => {
            let angle = PI / (n - 1) as f64;
            let ends = angle.sin() * (ring[0] + ring[n - 1]);
            -(1..n - 1)
                .fold(ends, |sum, i| sum + (2.0 * angle.cos() - 2.0) * (i as f64 * angle).sin() * ring[i])
        }
    };
    [ring[0] - ring[n - 1], second]
}

/// How normals follow from positions.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum NormalRule {
    /// [`loop_limit`].
    #[default]
    LoopLimit,
    /// [`angle_weighted`].
    AngleWeighted,
    /// [`area_weighted`].
    AreaWeighted,
}

/// A crease that turns by more than this at a vertex has a corner there (cosine of the angle, 70°): rounds are cut into six
/// sides or more, so that they stay round.
const CORNER_TURN: f64 = 0.342;

/// Two edges with a smaller sine of the angle between them do not say what plane they are in (10°).
const COLLINEAR: f64 = 0.17;

/// A unit normal for every corner (at the origin of each half edge): one for each of the [sectors] into
/// which the edges tagged in `sharp` cut the faces around a vertex; zero where the rule gives none.
///
/// Vertices that no sharp edge cuts get what the rule gives for the whole mesh. For [`NormalRule::LoopLimit`] a crease that
/// passes through a vertex has the boundary mask on both sides, so that both tangent planes hold its tangent; where
/// creases end, meet or turn sharply, the edges on both sides of a sector span the plane.
pub fn at_corners(mesh: &HalfEdgeMesh, positions: &[Point3], sharp: &[bool], rule: NormalRule) -> Vec<Vec3> {
    let whole = match rule {
        NormalRule::LoopLimit => loop_limit(mesh, positions),
        NormalRule::AngleWeighted => angle_weighted(mesh, positions),
        NormalRule::AreaWeighted => area_weighted(mesh, positions),
    };
    let mut normals: Vec<Vec3> = mesh.half_edges().map(|h| whole[mesh.origin(h).index()]).collect();
    let mut cut = vec![false; mesh.vertex_count()];
    for e in mesh.edges().filter(|e| sharp[e.index()]) {
        let h = mesh.edge_half_edge(e);
        [mesh.origin(h), mesh.dest(h)].into_iter().for_each(|v| cut[v.index()] = true);
    }
    for v in mesh.vertices().filter(|v| cut[v.index()]) {
        let sectors = sectors(mesh, sharp, v);
        if sectors.len() == 1 {
            continue;
        }
        // Two creases, or a crease in two sides, and no boundary.
        let through = sectors.len() == 2 && !mesh.is_boundary_vertex(v);
        for sector in &sectors {
            let normal = of_sector(mesh, positions, sector, through, rule);
            sector.iter().for_each(|h| normals[h.index()] = normal);
        }
    }
    normals
}

/// Unit normal of a sector between two edges.
fn of_sector(
    mesh: &HalfEdgeMesh,
    positions: &[Point3],
    sector: &[HalfEdgeId],
    through: bool,
    rule: NormalRule,
) -> Vec3 {
    let weight: fn(&Vec3, &Vec3) -> f64 = match rule {
        NormalRule::AreaWeighted => |a, b| a.cross(b).norm(),
        NormalRule::LoopLimit | NormalRule::AngleWeighted => angle_between,
    };
    let ring = ring_points(mesh, positions, sector, true);
    let of_face = |(h, pair): (&HalfEdgeId, &[Vec3])| {
        Some(weight(&pair[0], &pair[1]) * normal_seen_at(mesh, positions, *h)?)
    };
    let sum: Vec3 = sector.iter().zip(ring.windows(2)).filter_map(of_face).sum();
    let outward = sum.try_normalize(0.0).unwrap_or_else(Vec3::zeros);
    if rule != NormalRule::LoopLimit || sector.len() == 1 {
        return outward;
    }
    let [start, end] = [ring[0], ring[ring.len() - 1]].map(|v| v.try_normalize(0.0).unwrap_or_default());
    let passes = through && -start.dot(&end) > CORNER_TURN;
    let across = start.cross(&end);
    let normal = if passes || across.norm() < COLLINEAR {
        let [first, second] = boundary_tangents(&ring);
        first.cross(&second)
    } else {
        across
    };
    match normal.try_normalize(0.0) {
        Some(normal) if normal.dot(&outward) < 0.0 => -normal,
        Some(normal) => normal,
        None => outward,
    }
}

/// Unit normals of the faces; zero for a face without area.
pub fn of_faces(mesh: &HalfEdgeMesh, positions: &[Point3]) -> Vec<Vec3> {
    mesh.faces().map(|f| of_face(mesh, positions, f)).collect()
}

/// Unit normal of a face, of a polygon its mean normal; zero if it has no area.
pub fn of_face(mesh: &HalfEdgeMesh, positions: &[Point3], f: FaceId) -> Vec3 {
    (2.0 * area_vector(mesh, positions, f)).try_normalize(0.0).unwrap_or_else(Vec3::zeros)
}

#[cfg(test)]
#[allow(clippy::unwrap_used)]
mod tests {
    use super::*;

    /// A fan of `n` faces around a vertex at the origin, its ring on z = slope · x + level.
    fn fan(n: u32, closed: bool, level: f64) -> (HalfEdgeMesh, Vec<Point3>) {
        let ring = if closed { n } else { n + 1 };
        let angle = |i: u32| f64::from(i) * if closed { TAU / f64::from(n) } else { PI / f64::from(n) };
        let mut positions = vec![Point3::zeros()];
        positions.extend((0..ring).map(|i| Point3::new(angle(i).cos(), angle(i).sin(), level)));
        let faces: Vec<[u32; 3]> = (0..n).map(|i| [0, 1 + i, 1 + (i + 1) % ring]).collect();
        (HalfEdgeMesh::from_faces(positions.len(), &faces).unwrap(), positions)
    }

    #[test]
    fn a_regular_cone_has_its_axis_as_normal() {
        for n in 3..9 {
            let (mesh, positions) = fan(n, true, -0.5);
            for normals in [loop_limit, angle_weighted, area_weighted] {
                assert!((normals(&mesh, &positions)[0] - Vec3::z()).norm() < 1e-14, "valence {n}");
            }
        }
    }

    #[test]
    fn normals_of_an_open_flat_fan_point_up() {
        for n in 1..6 {
            let (mesh, positions) = fan(n, false, 0.0);
            for normals in [loop_limit, angle_weighted, area_weighted] {
                assert!(
                    normals(&mesh, &positions).iter().all(|m| (m - Vec3::z()).norm() < 1e-12),
                    "{n} faces"
                );
            }
        }
    }

    #[test]
    fn polygons_count_as_the_triangles_they_could_be_cut_into() {
        // A cube of quads, with the origin inside: all normals are along the diagonals.
        let signs = |k: u32| f64::from(2 * (k & 1)) - 1.0;
        let positions: Vec<Point3> =
            (0..8u32).map(|v| Point3::new(signs(v), signs(v >> 1), signs(v >> 2))).collect();
        let faces: [[u32; 4]; 6] =
            [[0, 2, 3, 1], [4, 5, 7, 6], [0, 1, 5, 4], [2, 6, 7, 3], [0, 4, 6, 2], [1, 3, 7, 5]];
        let mesh = HalfEdgeMesh::from_faces(8, &faces).unwrap();
        for normals in [angle_weighted, area_weighted, sphere_exact] {
            for (n, p) in normals(&mesh, &positions).iter().zip(&positions) {
                assert!((n - p.normalize()).norm() < 1e-15);
            }
        }
        assert_eq!(area_vector(&mesh, &positions, FaceId(0)), Vec3::new(0.0, 0.0, -4.0));
        // Of a polygon that is not planar, the mean normal.
        let bent = [[0.0, 0.0, 0.0], [1.0, 0.0, 1.0], [1.0, 1.0, 0.0], [0.0, 1.0, 1.0]].map(Point3::from);
        let quad = HalfEdgeMesh::from_faces(4, &[[0, 1, 2, 3]]).unwrap();
        assert_eq!(of_face(&quad, &bent, FaceId(0)), Vec3::z());
    }

    #[test]
    fn angle_weights_do_not_see_how_a_side_is_cut() {
        // The corner of a cube: sides z = 0, x = 0, y = 0 seen from outside; the first is cut into two.
        let p = [[0, 0, 0], [1, 0, 0], [0, 1, 0], [0, 0, 1], [1, 1, 0]];
        let positions: Vec<Point3> = p.map(|c| Point3::from(c.map(f64::from))).to_vec();
        let whole = HalfEdgeMesh::from_faces(4, &[[0, 2, 1], [0, 3, 2], [0, 1, 3]]).unwrap();
        let cut = HalfEdgeMesh::from_faces(5, &[[0, 2, 4], [0, 4, 1], [0, 3, 2], [0, 1, 3]]).unwrap();
        let [one, two] = [(&whole, 4), (&cut, 5)].map(|(mesh, n)| angle_weighted(mesh, &positions[..n])[0]);
        assert!((one - two).norm() < 1e-15);
        assert!((one - Vec3::new(-1.0, -1.0, -1.0).normalize()).norm() < 1e-15);
    }
}
