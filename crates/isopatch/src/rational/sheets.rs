//! Frames of surfaces with singular points and curves.

use super::frame::{Frame, FrameSeam};
use crate::geom::{Mat3, Point3, Vec3};
use std::collections::{BTreeMap, HashMap};

/// Normals of corners around a vertex of a singular curve that differ by more (cosine of 45°) have no common limit there.
const COMMON_ON_CURVE: f64 = 0.7;
/// The same at an isolated singular vertex (8°): around the tip of a flat cone normals differ little.
const COMMON_AT_POINT: f64 = 0.99;
/// Two tangents of singular curves with a smaller sine have no plane in common to speak of.
const LEAST_SINE: f64 = 0.05;

impl Frame {
    /// Triangles that conform to singular points and curves: `singular` has the edges along the curves by their vertices, and
    /// `singular_vertex` says which vertices are singular. `normals` are those at the corners, at singular vertices the limits along the
    /// triangle.
    ///
    /// Triangles that meet in an edge with two sides which is not singular make a sheet, G1. At a singular vertex each fan of a sheet has
    /// the mean of its limits for a normal, or none where they have no common one, as at the tip of a cone. Sheets end in singular
    /// edges, on wires that they share: along a curve the normals are turned into the planes at a right angle to its tangent, so that all
    /// sheets can have the same.
    pub fn over_sheets(
        positions: Vec<Point3>,
        faces: Vec<[u32; 3]>,
        normals: &[[Vec3; 3]],
        singular: &[[u32; 2]],
        singular_vertex: &[bool],
    ) -> Self {
        let seams = seams(&faces, singular);
        let fans = Fans::new(&faces, &seams);
        let mut of_fans = fans.normals(&faces, normals, singular, singular_vertex);
        fans.turn(&faces, &seams, singular, &mut of_fans);
        let normals = (0..faces.len()).map(|f| [0, 1, 2].map(|c| of_fans[fans.of_corner[3 * f + c]]));
        Self { normals: normals.collect(), positions, faces, seams }
    }
}

fn sorted([a, b]: [u32; 2]) -> [u32; 2] {
    [a.min(b), a.max(b)]
}

/// Smooth seams between two triangles with opposite directions of the edge; other triangles end alone in the wire.
fn seams(faces: &[[u32; 3]], singular: &[[u32; 2]]) -> Vec<FrameSeam> {
    let mut edges: BTreeMap<[u32; 2], Vec<(u32, u8)>> = BTreeMap::new();
    for (f, face) in faces.iter().enumerate() {
        for k in 0..3 {
            let ends = sorted([face[k], face[(k + 1) % 3]]);
            edges.entry(ends).or_default().push((f as u32, k as u8));
        }
    }
    let is_singular: std::collections::HashSet<[u32; 2]> = singular.iter().map(|e| sorted(*e)).collect();
    let start = |(f, k): (u32, u8)| faces[f as usize][usize::from(k)];
    let mut seams = Vec::with_capacity(edges.len());
    for (wire, (ends, sides)) in edges.into_iter().enumerate() {
        let wire = wire as u32;
        match sides[..] {
            [first, second] if !is_singular.contains(&ends) && start(first) != start(second) => {
                seams.push(FrameSeam { first, second: Some(second), smooth: true, wire });
            }
            _ => {
                let alone = |side: &(u32, u8)| FrameSeam { first: *side, second: None, smooth: false, wire };
                seams.extend(sides.iter().map(alone));
            }
        }
    }
    seams
}

/// Corners around a vertex that smooth seams join.
struct Fans {
    /// The fan of corner c of triangle f, at 3 f + c.
    of_corner: Vec<usize>,
    count: usize,
}

impl Fans {
    fn new(faces: &[[u32; 3]], seams: &[FrameSeam]) -> Self {
        let mut parents: Vec<usize> = (0..3 * faces.len()).collect();
        let corner = |(f, k): (u32, u8), end: usize| 3 * f as usize + (usize::from(k) + end) % 3;
        for seam in seams.iter().filter(|seam| seam.smooth) {
            if let Some(second) = seam.second {
                for (a, b) in
                    [(corner(seam.first, 0), corner(second, 1)), (corner(seam.first, 1), corner(second, 0))]
                {
                    let (a, b) = (root(&mut parents, a), root(&mut parents, b));
                    parents[a.max(b)] = a.min(b);
                }
            }
        }
        let mut numbers = HashMap::new();
        let of_corner = (0..parents.len()).map(|c| {
            let (root, next) = (root(&mut parents, c), numbers.len());
            *numbers.entry(root).or_insert(next)
        });
        let of_corner = of_corner.collect();
        Self { of_corner, count: numbers.len() }
    }

    /// The mean of the normals of each fan; none where a singular vertex has no common one.
    fn normals(
        &self,
        faces: &[[u32; 3]],
        normals: &[[Vec3; 3]],
        singular: &[[u32; 2]],
        singular_vertex: &[bool],
    ) -> Vec<Option<Vec3>> {
        let on_curve: std::collections::HashSet<u32> = singular.iter().flatten().copied().collect();
        let mut sums = vec![Vec3::zeros(); self.count];
        let corners = || (0..faces.len()).flat_map(|f| (0..3).map(move |c| (f, c)));
        for (f, c) in corners() {
            sums[self.of_corner[3 * f + c]] += normals[f][c].try_normalize(0.0).unwrap_or_else(Vec3::zeros);
        }
        let mut means: Vec<Option<Vec3>> = sums.iter().map(|sum| sum.try_normalize(f64::EPSILON)).collect();
        for (f, c) in corners() {
            let vertex = faces[f][c];
            let least = if on_curve.contains(&vertex) { COMMON_ON_CURVE } else { COMMON_AT_POINT };
            let mean = &mut means[self.of_corner[3 * f + c]];
            let is_singular = singular_vertex.get(vertex as usize).copied().unwrap_or(false);
            let differs = |mean: Vec3| mean.dot(&normals[f][c]) < least * normals[f][c].norm();
            if is_singular && mean.is_some_and(differs) {
                *mean = None;
            }
        }
        means
    }

    /// Makes the normals of all fans along a singular curve orthogonal to its tangent, which is that closest to all of their planes.
    fn turn(
        &self,
        faces: &[[u32; 3]],
        seams: &[FrameSeam],
        singular: &[[u32; 2]],
        normals: &mut [Option<Vec3>],
    ) {
        let is_singular: std::collections::HashSet<[u32; 2]> = singular.iter().map(|e| sorted(*e)).collect();
        // The fans at both ends of every side of a singular edge, by vertex.
        let mut ends: BTreeMap<u32, BTreeMap<u32, Vec<usize>>> = BTreeMap::new();
        for seam in seams {
            let (f, k) = seam.first;
            let corners = [usize::from(k), (usize::from(k) + 1) % 3];
            let vertices = corners.map(|c| faces[f as usize][c]);
            if is_singular.contains(&sorted(vertices)) {
                for (corner, vertex) in corners.into_iter().zip(vertices) {
                    let fan = self.of_corner[3 * f as usize + corner];
                    ends.entry(vertex).or_default().entry(seam.wire).or_default().push(fan);
                }
            }
        }
        for wires in ends.into_values() {
            // A curve through the vertex has one tangent there; where other than two edges meet, each has its own.
            let groups: Vec<Vec<usize>> = match wires.len() {
                2 => vec![wires.values().flatten().copied().collect()],
                _ => wires.into_values().collect(),
            };
            let mut lines: BTreeMap<usize, Vec<Vec3>> = BTreeMap::new();
            for group in &groups {
                let Some(line) = common_line(group.iter().filter_map(|fan| normals[*fan])) else { continue };
                group.iter().for_each(|fan| lines.entry(*fan).or_default().push(line));
            }
            for (fan, lines) in lines {
                normals[fan] = normals[fan].and_then(|n| orthogonal_to(n, &lines));
            }
        }
    }
}

fn root(parents: &mut [usize], mut i: usize) -> usize {
    while parents[i] != i {
        parents[i] = parents[parents[i]];
        i = parents[i];
    }
    i
}

/// The direction that is closest to being at a right angle to all normals; none if they are all the same up to sign.
fn common_line(normals: impl Iterator<Item = Vec3>) -> Option<Vec3> {
    let sum: Mat3 = normals.map(|n| n * n.transpose()).sum();
    let eigen = sum.symmetric_eigen();
    let order = eigen.eigenvalues;
    let (least, most) = (order.imin(), order.imax());
    let between = 3 - least - most;
    let spread = if least == most { 0.0 } else { order[between.min(2)] };
    // Equal normals leave a plane of directions.
    (spread > LEAST_SINE * LEAST_SINE * order[most]).then(|| eigen.eigenvectors.column(least).into_owned())
}

/// The normal turned to be at a right angle to all lines; none if that turns it far, or is not possible.
fn orthogonal_to(n: Vec3, lines: &[Vec3]) -> Option<Vec3> {
    let turned = match lines {
        [] => n,
        [line] => n - line * line.dot(&n),
        [first, second] => {
            let across = first.cross(second);
            if across.norm() < LEAST_SINE {
                // The same tangent twice.
                return orthogonal_to(n, &lines[..1]);
            }
            across * (across.dot(&n) / across.norm_squared())
        }
        _ => return None,
    };
    turned.try_normalize(COMMON_ON_CURVE)
}
