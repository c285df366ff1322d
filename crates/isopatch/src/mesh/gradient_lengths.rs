//! Lengths of gradients from unit normals: those with which every edge can be a chord of a quadric.

use super::{HalfEdgeMesh, VertexId};
use crate::geom::{Point3, Vec3};

/// Neighbouring lengths differ by no more than this factor: edges that ask for more say that no quadric is near.
const LARGEST_RATIO: f64 = 8.0;
/// Most steps of the solver. Every step carries lengths one edge farther, so that on large meshes they are right among
/// neighbours, on which the method relies, and drift at long range.
const MOST_STEPS: usize = 300;
/// The residual, relative to the first one, at which the solver stops: what rounding leaves.
const RESIDUAL: f64 = 1e-15;

/// An edge as an equation: the logarithm of the length at its end is that at its start plus `difference`.
#[derive(Clone, Copy)]
struct Chord {
    ends: [VertexId; 2],
    difference: f64,
    weight: f64,
}

/// The length of the gradient at each vertex, given its unit normal; the geometric mean of a component is about 1.
///
/// On a quadric Q = 0 the function is a parabola along each chord, with the same value at both ends, hence
/// (p_j − p_i)·(∇Q_i + ∇Q_j) = 0. With ∇Q_i = λ_i n_i this gives the ratio of λ_i and λ_j for every edge; their logarithms
/// are found from all edges by least squares, with weights that vanish where the edge is tangent to the surface. Edges
/// over which the surface turns from one side to the other are chords of no quadric, and left out. On a sphere all lengths
/// are 1. Exact for quadrics with exact normals. Takes at most 300 steps of conjugate gradients, each linear in the number
/// of edges.
pub fn recovered(mesh: &HalfEdgeMesh, positions: &[Point3], normals: &[Vec3]) -> Vec<f64> {
    let chord = |e| {
        let h = mesh.edge_half_edge(e);
        let ends = [mesh.origin(h), mesh.dest(h)];
        let chord = (positions[ends[1].index()] - positions[ends[0].index()]).try_normalize(0.0)?;
        let [at_start, at_end] = ends.map(|v| chord.dot(&normals[v.index()]));
        let limit = LARGEST_RATIO.ln();
        let difference = (-at_start / at_end).ln().clamp(-limit, limit);
        let weight = -at_start * at_end;
        (weight > 0.0 && difference.is_finite()).then_some(Chord { ends, difference, weight })
    };
    let chords: Vec<Chord> = mesh.edges().filter_map(chord).collect();
    logarithms(mesh.vertex_count(), &chords).into_iter().map(f64::exp).collect()
}

/// The least-squares solution of smallest size, by conjugate gradients with the diagonal as preconditioner.
fn logarithms(count: usize, chords: &[Chord]) -> Vec<f64> {
    let mut diagonal = vec![0.0; count];
    let mut residual = vec![0.0; count];
    for chord in chords {
        let [i, j] = chord.ends.map(VertexId::index);
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
        let [i, j] = chord.ends.map(VertexId::index);
        let pull = chord.weight * (x[j] - x[i]);
        out[i] -= pull;
        out[j] += pull;
    }
    out
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::hull::test_meshes::quadrics;

    /// Of every quadric that is bent along its edges the gradients come out, up to one factor.
    #[test]
    fn gradients_of_quadrics_are_recovered() {
        for (name, quadric, data) in quadrics() {
            let exact: Vec<f64> = data.positions().iter().map(|p| quadric.gradient(p).norm()).collect();
            let normals: Vec<Vec3> = data.positions().iter().map(|p| quadric.gradient(p).normalize()).collect();
            let found = recovered(data.mesh(), data.positions(), &normals);
            if name == "plane" {
                assert!(found.iter().all(|length| *length == 1.0));
                continue;
            }
            let ratios: Vec<f64> = found.iter().zip(&exact).map(|(found, exact)| found / exact).collect();
            let (least, most) = ratios.iter().fold((f64::MAX, 0.0f64), |(a, b), r| (a.min(*r), b.max(*r)));
            assert!(most / least < 1.0 + 1e-12, "{name}: {least} to {most}");
        }
    }
}
