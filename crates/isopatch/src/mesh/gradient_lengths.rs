//! Lengths of gradients from unit normals: those with which every edge, and every diagonal of a polygon, can be a chord of a quadric.

use super::{FaceId, HalfEdgeId, HalfEdgeMesh, creases};
use crate::geom::{Point3, Vec3};

/// Neighbouring lengths differ by no more than this factor: edges that ask for more say that no quadric is near.
const LARGEST_RATIO: f64 = 8.0;
/// Most steps of the solver. Every step carries lengths one edge farther, so that on large meshes they are right among
/// neighbours, on which the method relies, and drift at long range.
const MOST_STEPS: usize = 300;
/// The residual, relative to the first one, at which the solver stops: what rounding leaves.
const RESIDUAL: f64 = 1e-15;

/// The product of the sines of an edge with the tangent planes at its ends below which a chord across it stands in for it.
const TANGENT: f64 = 1e-12;

/// An edge as an equation: the logarithm of the length at its end is that at its start plus `difference`. Corners between
/// which there is no sharp edge have one length: `ends` are numbers of such sectors.
#[derive(Clone, Copy)]
struct Chord {
    ends: [usize; 2],
    difference: f64,
    weight: f64,
}

/// The length of the gradient at each corner (the origin of each half edge), given the unit normals of the corners, which
/// may differ where sharp edges are between them; the geometric mean of a component is about 1.
///
/// On a quadric Q = 0 the function is a parabola along each chord, with the same value at both ends, hence
/// (p_j − p_i)·(∇Q_i + ∇Q_j) = 0. With ∇Q_i = λ_i n_i this gives the ratio of λ_i and λ_j for every edge; their logarithms
/// are found from all edges by least squares, with weights that vanish where the edge is tangent to the surface. Edges
/// over which the surface turns from one side to the other are chords of no quadric, and left out. On a sphere all lengths
/// are 1. Exact for quadrics with exact normals. Takes at most 300 steps of conjugate gradients, each linear in the number
/// of edges.
pub fn recovered(
    mesh: &HalfEdgeMesh,
    positions: &[Point3],
    sharp: &[bool],
    corner_normals: &[Vec3],
) -> Vec<f64> {
    let (sector, count) = sectors(mesh, sharp);
    let chord = |ends: [HalfEdgeId; 2]| {
        let [p, q] = ends.map(|h| positions[mesh.origin(h).index()]);
        let along = (q - p).try_normalize(0.0)?;
        let [at_start, at_end] = ends.map(|h| along.dot(&corner_normals[h.index()]));
        let limit = LARGEST_RATIO.ln();
        let difference = (-at_start / at_end).ln().clamp(-limit, limit);
        let weight = -at_start * at_end;
        let ends = ends.map(|h| sector[h.index()]);
        (weight > 0.0 && difference.is_finite()).then_some(Chord { ends, difference, weight })
    };
    let seen_from = |e| {
        let h = mesh.edge_half_edge(e);
        [Some(h), mesh.twin(h).filter(|_| sharp[mesh.edge(h).index()])]
    };
    let along_edge = |h: HalfEdgeId| {
        let own = chord([h, mesh.next(h)]);
        if own.is_some_and(|own| own.weight > TANGENT) {
            return own;
        }
        across(mesh, sharp, h).and_then(chord).or(own)
    };
    let edges = mesh.edges().flat_map(seen_from).flatten().filter_map(along_edge);
    let chords: Vec<Chord> =
        edges.chain(mesh.faces().flat_map(|f| diagonals(mesh, f)).filter_map(chord)).collect();
    let lengths: Vec<f64> = logarithms(count, &chords).into_iter().map(f64::exp).collect();
    sector.into_iter().map(|s| lengths[s]).collect()
}

/// The chord that stands in for an edge between two larger polygons along which the surface is straight, as along the lines of a
/// saddle: it crosses the edge, from the corner before its start on one side to that on the other.
fn across(mesh: &HalfEdgeMesh, sharp: &[bool], h: HalfEdgeId) -> Option<[HalfEdgeId; 2]> {
    let g = mesh.twin(h).filter(|_| !sharp[mesh.edge(h).index()])?;
    let larger = |h| mesh.face_half_edges(mesh.face(h)).len() > 3;
    (larger(h) && larger(g)).then(|| [mesh.prev(h), mesh.prev(g)])
}

/// The shortest diagonals of a polygon, from each corner to the next but one, as half edges that start at their ends: chords as the
/// edges are, which tell more where the edges are tangent to the surface. A triangle has none.
fn diagonals(mesh: &HalfEdgeMesh, f: FaceId) -> impl Iterator<Item = [HalfEdgeId; 2]> + '_ {
    let count = match mesh.face_half_edges(f).len() {
        3 => 0,
        4 => 2,
        n => n,
    };
    mesh.face_half_edges(f).take(count).map(|h| [h, mesh.next(mesh.next(h))])
}

/// The number of the sector that each corner is in, and how many there are.
fn sectors(mesh: &HalfEdgeMesh, sharp: &[bool]) -> (Vec<usize>, usize) {
    let mut number = vec![0; mesh.half_edge_count()];
    let mut count = 0;
    for v in mesh.vertices() {
        for sector in creases::sectors(mesh, sharp, v) {
            sector.iter().for_each(|h| number[h.index()] = count);
            count += 1;
        }
    }
    (number, count)
}

/// The least-squares solution of smallest size, by conjugate gradients with the diagonal as preconditioner.
fn logarithms(count: usize, chords: &[Chord]) -> Vec<f64> {
    let mut diagonal = vec![0.0; count];
    let mut residual = vec![0.0; count];
    for chord in chords {
        let [i, j] = chord.ends;
        diagonal[i] += chord.weight;
        diagonal[j] += chord.weight;
        residual[i] -= chord.weight * chord.difference;
        residual[j] += chord.weight * chord.difference;
    }
    let preconditioned = |r: &[f64]| -> Vec<f64> {
        r.iter().zip(&diagonal).map(|(r, d)| if *d > 0.0 { r / d } else { 0.0 }).collect()
    };
    let mut solution = vec![0.0; count];
    let mut scaled = preconditioned(&residual);
    let mut direction = scaled.clone();
    let mut size = dot(&residual, &scaled);
    let enough = RESIDUAL * RESIDUAL * size;
    for _ in 0..MOST_STEPS {
        if size <= enough {
            break;
        }
        let image = applied(chords, &direction);
        let step = size / dot(&direction, &image);
        if !step.is_finite() {
            break;
        }
        for i in 0..count {
            solution[i] += step * direction[i];
            residual[i] -= step * image[i];
        }
        scaled = preconditioned(&residual);
        let next = dot(&residual, &scaled);
        let share = next / size;
        direction.iter_mut().zip(&scaled).for_each(|(d, s)| *d = s + share * *d);
        size = next;
    }
    solution
}

fn dot(a: &[f64], b: &[f64]) -> f64 {
    a.iter().zip(b).map(|(a, b)| a * b).sum()
}

/// The matrix of the normal equations times a vector.
fn applied(chords: &[Chord], x: &[f64]) -> Vec<f64> {
    let mut out = vec![0.0; x.len()];
    for chord in chords {
        let [i, j] = chord.ends;
        let pull = chord.weight * (x[j] - x[i]);
        out[i] -= pull;
        out[j] += pull;
    }
    out
}

#[cfg(test)]
#[allow(clippy::unwrap_used)]
mod tests {
    use super::*;
    use crate::hull::test_meshes::quadrics;

    /// Of every quadric that is bent along its edges the gradients come out, up to one factor.
    #[test]
    fn gradients_of_quadrics_are_recovered() {
        for (name, quadric, data) in quadrics() {
            let of_corners: Vec<Vec3> = {
                let at = |h| quadric.gradient(&data.positions()[data.mesh().origin(h).index()]);
                data.mesh().half_edges().map(at).collect()
            };
            let normals: Vec<Vec3> = of_corners.iter().map(Vec3::normalize).collect();
            let sharp = vec![false; data.mesh().edge_count()];
            let found = recovered(data.mesh(), data.positions(), &sharp, &normals);
            if name == "plane" {
                assert!(found.iter().all(|length| *length == 1.0));
                continue;
            }
            let ratios = found.iter().zip(&of_corners).map(|(found, exact)| found / exact.norm());
            let (least, most) = ratios.fold((f64::MAX, 0.0f64), |(a, b), r| (a.min(r), b.max(r)));
            assert!(most / least < 1.0 + 1e-12, "{name}: {least} to {most}");
        }
    }

    /// A cylinder with flat ends: along its side all lengths are alike, whatever the ends have.
    #[test]
    fn sharp_edges_separate_lengths() {
        let turn = |i: u32| std::f64::consts::TAU * f64::from(i % 6) / 6.0;
        let ring = |z: f64| (0..6).map(move |i| Point3::new(turn(i).cos(), turn(i).sin(), z));
        let positions: Vec<Point3> = ring(0.0).chain(ring(3.0)).collect();
        let side = (0..6u32).flat_map(|i| {
            let [a, b] = [i, (i + 1) % 6];
            [[a, b, b + 6], [a, b + 6, a + 6]]
        });
        let lids = (1..5u32).flat_map(|i| [[0, i + 1, i], [6, 6 + i, 7 + i]]);
        let faces: Vec<[u32; 3]> = side.chain(lids).collect();
        let mesh = HalfEdgeMesh::from_faces(12, &faces).unwrap();
        let sharp = creases::by_angle(&mesh, &positions, 1.2);
        assert_eq!(sharp.iter().filter(|sharp| **sharp).count(), 12);
        let is_lid = |h: HalfEdgeId| mesh.face(h).0 >= 12;
        let normal = |h: HalfEdgeId| {
            let p = positions[mesh.origin(h).index()];
            if is_lid(h) { Vec3::new(0.0, 0.0, p.z - 1.5).normalize() } else { Vec3::new(p.x, p.y, 0.0) }
        };
        let normals: Vec<Vec3> = mesh.half_edges().map(normal).collect();
        let found = recovered(&mesh, &positions, &sharp, &normals);
        assert!(found.iter().all(|length| (length - 1.0).abs() < 1e-12), "{found:?}");
    }
}
