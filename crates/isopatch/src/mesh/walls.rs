//! Faces that two touching bodies have in common, once for each.

use super::polygons::{Edges, Joined, Polygons};

/// Fewest faces at an edge of a wall: the two sides of the wall, and two of the bodies or of the next piece of wall.
const FACES_AT_WALL: usize = 4;

/// Which of the duplicates (pairs of a face and the first one with its corners) are the other side of a wall between
/// bodies, and belong there.
///
/// A wall is made of faces that are there twice, in opposite orientation. At each of its edges an even number of faces
/// meets, four or more, and somewhere it meets other faces. A two-sided sheet with a free edge is none, nor is a closed
/// surface that is there twice.
pub(super) fn other_sides(polygons: &Polygons, duplicates: &[[usize; 2]]) -> Vec<bool> {
    let mut copies = vec![0usize; polygons.len()];
    duplicates.iter().for_each(|[_, first]| copies[*first] += 1);
    let is_candidate = |[f, first]: &[usize; 2]| {
        copies[*first] == 1 && are_opposite(polygons.face(*f), polygons.face(*first))
    };
    let is_candidate: Vec<bool> = duplicates.iter().map(is_candidate).collect();
    // The number of the pair that a face belongs to.
    let mut pair_of = vec![None; polygons.len()];
    for (i, [f, first]) in duplicates.iter().enumerate().filter(|(i, _)| is_candidate[*i]) {
        pair_of[*f] = Some(i as u32);
        pair_of[*first] = Some(i as u32);
    }
    let mut wall = Joined::new(duplicates.len());
    let (mut is_sound, mut is_attached) = (is_candidate, vec![false; duplicates.len()]);
    let edges = Edges::new(polygons);
    for half_edges in edges.iter() {
        let pair = |h: &u32| pair_of[edges.face[*h as usize] as usize];
        let Some(pivot) = half_edges.iter().find_map(pair) else { continue };
        for other in half_edges.iter().map(pair) {
            match other {
                Some(other) => wall.join(pivot, other),
                None => is_attached[pivot as usize] = true,
            }
        }
        is_sound[pivot as usize] &= half_edges.len() >= FACES_AT_WALL && half_edges.len().is_multiple_of(2);
    }
    // What holds for a piece holds for its wall.
    for i in 0..duplicates.len() {
        let root = wall.root(i as u32) as usize;
        is_sound[root] &= is_sound[i];
        is_attached[root] |= is_attached[i];
    }
    (0..duplicates.len())
        .map(|i| wall.root(i as u32) as usize)
        .map(|root| is_sound[root] && is_attached[root])
        .collect()
}

/// Do two faces with the same corners name them in opposite directions?
fn are_opposite(f: &[u32], g: &[u32]) -> bool {
    let start = g.iter().position(|v| *v == f[0]).unwrap_or(0);
    g[(start + 1) % g.len()] != f[1]
}
