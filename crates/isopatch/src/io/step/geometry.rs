//! The entities of corners, seams and patches.

use super::decimals::{Decimals, Digits, TOGETHER, WIDTH};
use super::numbering::Numbering;
use crate::bernstein::{curve, quads};
use crate::geom::Point3;
use crate::io::net::{DEGREE, Net};
use crate::io::text::{NINE_DIGITS, push_integer, push_real};
use crate::surface::PatchId;

/// Which way the normals of a patch's faces point.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Facing {
    /// As the patch's.
    Kept,
    /// Against the patch's: the two parameters of each surface are exchanged.
    Turned,
}

/// Control points strictly inside a curve.
const INNER: usize = DEGREE - 1;

#[inline(always)]
fn begin(text: &mut Vec<u8>, id: u64, rest: &str) {
    text.push(b'#');
    push_integer(text, id);
    text.push(b'=');
    text.extend_from_slice(rest.as_bytes());
}

/// Appends a list of entities.
pub fn push_references(text: &mut Vec<u8>, ids: impl Iterator<Item = u64>) {
    text.push(b'(');
    for (k, id) in ids.enumerate() {
        text.extend_from_slice(if k == 0 { b"#" } else { b",#" });
        push_integer(text, id);
    }
    text.push(b')');
}

/// Points whose coordinates are turned into digits together.
const POINTS: usize = TOGETHER / 3;
const POINT: &[u8; 21] = b"=CARTESIAN_POINT('',(";
/// Characters of a point of fewer than nine digits: its number, and three coordinates with what stands after each.
const LINE: usize = 9 + POINT.len() + 3 * (WIDTH + 1) + 3;

/// Appends points, numbered from `first` on.
fn push_points(text: &mut Vec<u8>, decimals: Decimals, first: u64, points: &[Point3]) {
    for (start, points) in (first..).step_by(POINTS).zip(points.chunks(POINTS)) {
        let mut coordinates = [0.0; TOGETHER];
        for (xyz, p) in coordinates.chunks_exact_mut(3).zip(points) {
            xyz.copy_from_slice(p.as_slice());
        }
        match decimals.digits(&coordinates) {
            Some(digits) if start + (POINTS as u64) < NINE_DIGITS => {
                (0..points.len()).for_each(|k| push_point_of(text, start + k as u64, &digits, k));
            }
            _ => (start..).zip(points).for_each(|(id, p)| push_point(text, id, p)),
        }
    }
}

/// Appends point `k` of those whose digits are given: in room for the longest, so that its length stays in a register.
#[inline(always)]
fn push_point_of(text: &mut Vec<u8>, id: u64, digits: &Digits, k: usize) {
    text.push(b'#');
    push_integer(text, id);
    let start = text.len();
    text.extend_from_slice(&[0; LINE]);
    let line = &mut text[start..];
    line[..POINT.len()].copy_from_slice(POINT);
    let mut at = POINT.len();
    for coordinate in 3 * k..3 * k + 3 {
        at = digits.put(coordinate, line, at);
        line[at] = b',';
        at += 1;
    }
    // In place of the last comma.
    line[at - 1..at + 3].copy_from_slice(b"));\n");
    text.truncate(start + at + 3);
}

fn push_point(text: &mut Vec<u8>, id: u64, p: &Point3) {
    begin(text, id, "CARTESIAN_POINT('',(");
    push_real(text, p.x);
    text.push(b',');
    push_real(text, p.y);
    text.push(b',');
    push_real(text, p.z);
    text.extend_from_slice(b"));\n");
}

fn push_vertex(text: &mut Vec<u8>, id: u64, point: u64) {
    begin(text, id, "VERTEX_POINT('',#");
    push_integer(text, point);
    text.extend_from_slice(b");\n");
}

fn push_curve(text: &mut Vec<u8>, id: u64, points: impl Iterator<Item = u64>) {
    begin(text, id, "B_SPLINE_CURVE_WITH_KNOTS('',7,");
    push_references(text, points);
    text.extend_from_slice(b",.UNSPECIFIED.,.F.,.F.,(8,8),(0.,1.),.UNSPECIFIED.);\n");
}

fn push_edge(text: &mut Vec<u8>, id: u64, from: u64, to: u64, curve: u64) {
    begin(text, id, "EDGE_CURVE('',#");
    push_integer(text, from);
    text.extend_from_slice(b",#");
    push_integer(text, to);
    text.extend_from_slice(b",#");
    push_integer(text, curve);
    text.extend_from_slice(b",.T.);\n");
}

/// A corner: its point and vertex.
pub fn push_corner(text: &mut Vec<u8>, ids: &Numbering, decimals: Decimals, corner: u32, p: &Point3) {
    push_points(text, decimals, ids.corner_point(corner), std::slice::from_ref(p));
    push_vertex(text, ids.corner_vertex(corner), ids.corner_point(corner));
}

/// A seam from its control points and end corners: its two halves, which meet in a vertex at t = 1/2.
pub fn push_seam(
    text: &mut Vec<u8>,
    ids: &Numbering,
    decimals: Decimals,
    seam: u32,
    row: &[Point3; DEGREE + 1],
    ends: [u32; 2],
) {
    let (first, second) = curve::split_half(row);
    // In the order of their numbers.
    let mut points = [second[0]; 1 + 2 * INNER];
    points[1..=INNER].copy_from_slice(&first[1..DEGREE]);
    points[1 + INNER..].copy_from_slice(&second[1..DEGREE]);
    push_points(text, decimals, ids.seam(seam), &points);
    push_vertex(text, ids.seam_vertex(seam), ids.seam(seam));
    for half in 0..2 {
        let point = |m| match (half, m) {
            (0, 0) => ids.corner_point(ends[0]),
            (1, DEGREE) => ids.corner_point(ends[1]),
            (_, 0 | DEGREE) => ids.seam(seam),
            _ => ids.seam_inner(seam, half, m),
        };
        push_curve(text, ids.seam_curve(seam, half), (0..=DEGREE).map(point));
    }
    let (start, middle, end) =
        (ids.corner_vertex(ends[0]), ids.seam_vertex(seam), ids.corner_vertex(ends[1]));
    push_edge(text, ids.seam_edge(seam, 0), start, middle, ids.seam_curve(seam, 0));
    push_edge(text, ids.seam_edge(seam, 1), middle, end, ids.seam_curve(seam, 1));
}

/// A patch: its centroid, three spokes and three faces. Borders refer to the points of corners and seams.
pub fn push_patch(
    text: &mut Vec<u8>,
    ids: &Numbering,
    decimals: Decimals,
    patch: PatchId,
    net: &Net,
    facing: Facing,
) {
    let quads = quads::split(net);
    // In the order of their numbers.
    let mut points = [quads[0][DEGREE][DEGREE]; 1 + 3 * INNER * (1 + INNER)];
    let spokes = quads.iter().map(|quad| &quad[DEGREE]);
    let rows = spokes.chain(quads.iter().flat_map(|quad| &quad[1..DEGREE]));
    for (inner, row) in points[1..].chunks_exact_mut(INNER).zip(rows) {
        inner.copy_from_slice(&row[1..DEGREE]);
    }
    push_points(text, decimals, ids.patch(patch), &points);
    push_vertex(text, ids.centroid_vertex(patch), ids.patch(patch));
    for spoke in 0..3 {
        let points = (0..=DEGREE).map(|m| ids.spoke_point(patch, spoke, m));
        push_curve(text, ids.spoke_curve(patch, spoke), points);
    }
    for (spoke, side) in ids.lattice().edges(patch).iter().enumerate() {
        let (from, to) = (ids.seam_vertex(side.seam), ids.centroid_vertex(patch));
        push_edge(text, ids.spoke_edge(patch, spoke), from, to, ids.spoke_curve(patch, spoke));
    }
    (0..3).for_each(|q| push_face(text, ids, patch, q, facing));
}

fn push_face(text: &mut Vec<u8>, ids: &Numbering, patch: PatchId, q: usize, facing: Facing) {
    let surface = ids.quad(patch, q);
    begin(text, surface, "B_SPLINE_SURFACE_WITH_KNOTS('',7,7,(");
    for a in 0..=DEGREE {
        if a > 0 {
            text.push(b',');
        }
        push_references(
            text,
            (0..=DEGREE).map(|b| match facing {
                Facing::Kept => ids.quad_point(patch, q, a, b),
                Facing::Turned => ids.quad_point(patch, q, b, a),
            }),
        );
    }
    let knots = "),.UNSPECIFIED.,.F.,.F.,.F.,(8,8),(8,8),(0.,1.),(0.,1.),.UNSPECIFIED.);\n";
    text.extend_from_slice(knots.as_bytes());
    let mut border = ids.quad_loop(patch, q);
    if facing == Facing::Turned {
        border.reverse();
        border.iter_mut().for_each(|(_, forward)| *forward = !*forward);
    }
    for (id, (edge, forward)) in (surface + 1..).zip(border) {
        begin(text, id, "ORIENTED_EDGE('',*,*,#");
        push_integer(text, edge);
        text.extend_from_slice(if forward { b",.T.);\n" } else { b",.F.);\n" });
    }
    begin(text, surface + 5, "EDGE_LOOP('',");
    push_references(text, surface + 1..surface + 5);
    text.extend_from_slice(b");\n");
    begin(text, surface + 6, "FACE_OUTER_BOUND('',#");
    push_integer(text, surface + 5);
    text.extend_from_slice(b",.T.);\n");
    begin(text, surface + 7, "ADVANCED_FACE('',(#");
    push_integer(text, surface + 6);
    text.extend_from_slice(b"),#");
    push_integer(text, surface);
    text.extend_from_slice(b",.T.);\n");
}
