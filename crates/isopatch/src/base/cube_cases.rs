//! The 256 cases of marching cubes, resolved so that the union of all cells is a closed 2-manifold.
//!
//! ```text
//!       6-------7        corner c has x = bit 0, y = bit 1, z = bit 2
//!      /|      /|
//!     4-------5 |        edge 4·axis + k runs along `axis` from the corner whose other two
//!     | |     | |        coordinates are the bits of k, lower axis first:
//!     | 2-----|-3          x edges 0…3 start at corners 0 2 4 6
//!     |/      |/           y edges 4…7 start at corners 0 1 4 5
//!     0-------1            z edges 8…11 start at corners 0 1 2 3
//! ```
//!
//! Each face of the cube joins its crossings by segments that cut off every run of inside corners by itself. This
//! rule reads only the face, so both cells beside it agree, and the segments of a cell close up to loops. A loop is
//! filled without any diagonal between two edges of one cube face; such a diagonal could be repeated by the cell on
//! the other side, and an edge with four triangles would result. No other edges are shared between cells.

/// Triangles of one case, as cube edges; edge 12 + i is the middle of the i-th loop in `centers`.
#[derive(Clone, Debug, Default)]
pub(super) struct CubeCase {
    /// Counter-clockwise seen from outside (f > 0).
    pub triangles: Vec<[u8; 3]>,
    /// Loops that need a vertex in their middle.
    pub centers: Vec<Vec<u8>>,
}

/// Corner where an edge starts; it ends at the corner with bit `edge / 4` set.
pub(super) const fn edge_start(edge: usize) -> usize {
    let (axis, k) = (edge / 4, edge % 4);
    match axis {
        0 => k << 1,
        1 => (k & 1) | ((k & 2) << 1),
        _ => k,
    }
}

/// Corners of each cube face, counter-clockwise seen from outside the cube.
const FACES: [[usize; 4]; 6] =
    [[0, 4, 6, 2], [1, 3, 7, 5], [0, 1, 5, 4], [2, 6, 7, 3], [0, 2, 3, 1], [4, 5, 7, 6]];

/// First vertex number of a triangle that stands for a loop's middle.
pub(super) const FIRST_CENTER: u8 = 12;

fn edge_between(a: usize, b: usize) -> u8 {
    let axis = (a ^ b).trailing_zeros() as usize;
    let start = a.min(b);
    (0..4).map(|k| 4 * axis + k).find(|e| edge_start(*e) == start).unwrap_or(0) as u8
}

/// Do both edges lie in one face of the cube?
fn on_one_face(e: u8, g: u8) -> bool {
    FACES.iter().any(|face| {
        let has = |edge: u8| (0..4).any(|i| edge_between(face[i], face[(i + 1) % 4]) == edge);
        has(e) && has(g)
    })
}

/// Following edge on the loop of every crossed edge; bit c of `inside` says whether corner c has f < 0.
fn successors(inside: u8) -> [Option<u8>; 12] {
    let is_inside = |c: usize| inside >> c & 1 == 1;
    let mut next = [None; 12];
    for face in FACES {
        for i in 0..4 {
            // A run of inside corners starts after a step from outside; follow it to its end.
            let (before, first) = (face[i], face[(i + 1) % 4]);
            if is_inside(before) || !is_inside(first) {
                continue;
            }
            let mut j = i + 1;
            while is_inside(face[(j + 1) % 4]) {
                j += 1;
            }
            let leaving = edge_between(face[j % 4], face[(j + 1) % 4]);
            next[edge_between(before, first) as usize] = Some(leaving);
        }
    }
    next
}

fn fan_without_face_diagonals(polygon: &[u8]) -> Option<Vec<[u8; 3]>> {
    let n = polygon.len();
    let at = |i: usize| polygon[i % n];
    (0..n)
        .find(|s| (2..n - 1).all(|i| !on_one_face(at(*s), at(s + i))))
        .map(|s| (1..n - 1).map(|i| [at(s), at(s + i), at(s + i + 1)]).collect())
}

fn cube_case(inside: u8) -> CubeCase {
    let mut next = successors(inside);
    let mut case = CubeCase::default();
    for start in 0..12 {
        let mut polygon = Vec::new();
        let mut edge = start;
        while let Some(following) = next[edge].take() {
            polygon.push(edge as u8);
            edge = following as usize;
        }
        if polygon.is_empty() {
            continue;
        }
        if let Some(triangles) = fan_without_face_diagonals(&polygon) {
            case.triangles.extend(triangles);
            continue;
        }
        let center = FIRST_CENTER + case.centers.len() as u8;
        let n = polygon.len();
        case.triangles.extend((0..n).map(|i| [center, polygon[i], polygon[(i + 1) % n]]));
        case.centers.push(polygon);
    }
    case
}

/// All cases; the index has bit c set where corner c is inside (f < 0).
pub(super) fn cube_cases() -> Vec<CubeCase> {
    (0..=u8::MAX).map(cube_case).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn one_inside_corner_gives_a_triangle_that_looks_outward() {
        assert_eq!(cube_case(1).triangles, [[0, 4, 8]]);
    }

    #[test]
    fn every_crossed_edge_lies_on_one_loop_and_no_diagonal_on_a_face() {
        for (inside, case) in cube_cases().iter().enumerate() {
            for edge in 0..12 {
                let (a, b) = (edge_start(edge), edge_start(edge) | 1 << (edge / 4));
                let crossed = (inside >> a ^ inside >> b) & 1 == 1;
                let used = case.triangles.iter().flatten().any(|v| *v as usize == edge);
                assert_eq!(crossed, used, "case {inside} edge {edge}");
            }
            let directed: Vec<(u8, u8)> =
                case.triangles.iter().flat_map(|t| [(t[0], t[1]), (t[1], t[2]), (t[2], t[0])]).collect();
            for (a, b) in &directed {
                assert_eq!(directed.iter().filter(|e| *e == &(*a, *b)).count(), 1);
                let interior = directed.contains(&(*b, *a));
                let on_face = *a < FIRST_CENTER && *b < FIRST_CENTER && on_one_face(*a, *b);
                assert_eq!(interior, !on_face, "case {inside}");
            }
        }
    }
}
