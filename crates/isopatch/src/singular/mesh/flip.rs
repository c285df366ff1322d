//! Flipping edges of a conforming mesh where that makes triangles better.

use std::collections::BTreeSet;

use super::decimate::Limits;
use super::quality::Judge;
use super::singular_mesh::{EdgeTag, SingularMesh};
use crate::field::Field;

/// A flip has to raise the quality of the worse triangle by this much.
const WORTH: f64 = 0.02;
/// Rounds over all edges.
const ROUNDS: usize = 8;

/// Flips smooth edges as long as the worse of the two triangles gets better; the number of flips.
pub(super) fn flip(field: &dyn Field, mesh: &mut SingularMesh, limits: Limits) -> usize {
    let mut flips = 0;
    for _ in 0..ROUNDS {
        let done = pass(field, mesh, limits);
        flips += done;
        if done == 0 {
            break;
        }
    }
    flips
}

fn pass(field: &dyn Field, mesh: &mut SingularMesh, limits: Limits) -> usize {
    let edges = mesh.edges();
    let mut known: BTreeSet<[u32; 2]> = edges.keys().copied().collect();
    let smooth = edges.iter().filter(|(ends, t)| t.len() == 2 && mesh.tag(**ends, 2) == EdgeTag::Smooth);
    let smooth: Vec<([u32; 2], [u32; 2])> = smooth.map(|(ends, t)| (*ends, [t[0], t[1]])).collect();
    let judge = Judge::new(field, &mesh.positions, &mesh.vertices, limits);
    let mut moved = vec![false; mesh.triangles.len()];
    let mut flips = 0;
    for ([a, b], [s, t]) in smooth {
        if moved[s as usize] || moved[t as usize] {
            continue;
        }
        let (first, second) = (mesh.triangles[s as usize], mesh.triangles[t as usize]);
        let (Some(c), Some(d)) = (opposite(first, a, b), opposite(second, a, b)) else { continue };
        let (c_d, ends) = ([c.min(d), c.max(d)], [a, b]);
        // The new triangles run like the first one: from → to is its edge a, b.
        let [from, to] = if follows(first, a, b) { ends } else { [b, a] };
        let new = [[from, d, c], [d, to, c]];
        if c == d || known.contains(&c_d) {
            continue;
        }
        let old_quality = judge.quality(first).min(judge.quality(second));
        let quality = new.iter().map(|t| judge.quality(*t)).fold(f64::INFINITY, f64::min);
        if quality > old_quality + WORTH && new.iter().all(|t| judge.is_near(*t)) {
            (mesh.triangles[s as usize], mesh.triangles[t as usize]) = (new[0], new[1]);
            (moved[s as usize], moved[t as usize]) = (true, true);
            known.remove(&[a, b]);
            known.insert(c_d);
            flips += 1;
        }
    }
    flips
}

/// The corner that is neither.
fn opposite(corners: [u32; 3], a: u32, b: u32) -> Option<u32> {
    corners.into_iter().find(|v| *v != a && *v != b)
}

/// Does b come after a?
fn follows(corners: [u32; 3], a: u32, b: u32) -> bool {
    (0..3).any(|k| corners[k] == a && corners[(k + 1) % 3] == b)
}
