//! Singular arcs as curves with a parameter, and their pieces in cells.

use crate::geom::{Point3, Vec3};
use crate::singular::{CurveKind, SingularCurve};

use super::grid::{Cell, Tree, size};

/// A singular arc: a cubic between every two samples.
pub(super) struct Arc {
    pub(super) kind: CurveKind,
    pub(super) closed: bool,
    /// The special points at its ends.
    pub(super) ends: Option<[usize; 2]>,
    points: Vec<Point3>,
    tangents: Vec<Vec3>,
}

/// Where a piece of an arc ends.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) enum PieceEnd {
    /// At a centre, by its number.
    Center(usize),
    /// Where the parameter of a closed arc begins anew.
    Seam,
    /// In a plane of the grid.
    Plane { axis: usize, key: u32 },
}

/// A piece of an arc.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Piece {
    pub(super) arc: usize,
    pub(super) range: [f64; 2],
    pub(super) ends: [PieceEnd; 2],
}

/// Bisections for a parameter where an arc meets a plane.
const BISECTIONS: usize = 60;

impl Arc {
    /// `snap` moves points that are all but in a side of the box into it.
    pub(super) fn new(curve: &SingularCurve, snap: impl Fn(Point3) -> Point3) -> Self {
        let mut points: Vec<Point3> = curve.samples.iter().map(|s| snap(s.at)).collect();
        let mut tangents: Vec<Vec3> = curve.samples.iter().map(|s| s.tangent).collect();
        if curve.closed {
            points.push(points[0]);
            tangents.push(tangents[0]);
        }
        Self { kind: curve.kind, closed: curve.closed, ends: curve.ends, points, tangents }
    }

    /// The largest parameter; the smallest is 0.
    pub(super) fn length(&self) -> f64 {
        (self.points.len() - 1) as f64
    }

    /// The point with a parameter; that of a closed arc goes on from the beginning.
    pub(super) fn at(&self, t: f64) -> Point3 {
        let t = if self.closed { t.rem_euclid(self.length()) } else { t.clamp(0.0, self.length()) };
        let i = (t as usize).min(self.points.len() - 2);
        let t = t - i as f64;
        let (a, b) = (self.points[i], self.points[i + 1]);
        let chord = (b - a).norm();
        let s = 1.0 - t;
        a * (s * s * (1.0 + 2.0 * t))
            + b * (t * t * (1.0 + 2.0 * s))
            + (self.tangents[i] * (s * s * t) - self.tangents[i + 1] * (t * t * s)) * chord
    }

    /// Points along it, no farther apart than `spacing`.
    pub(super) fn points(&self, spacing: f64) -> impl Iterator<Item = Point3> {
        let steps = self.points.windows(2).map(move |w| ((w[1] - w[0]).norm() / spacing).ceil().max(1.0) as usize);
        let steps: Vec<usize> = steps.collect();
        let parameters = steps.into_iter().enumerate().flat_map(|(i, n)| (0..n).map(move |k| i as f64 + k as f64 / n as f64));
        parameters.chain([self.length()]).map(|t| self.at(t))
    }

    /// The special point with which a parameter begins or ends an arc.
    pub(super) fn end_at(&self, t: f64) -> Option<usize> {
        let [first, last] = self.ends?;
        if t == 0.0 {
            Some(first)
        } else if t == self.length() {
            Some(last)
        } else {
            None
        }
    }

    /// Parameters in the range at which a coordinate takes a value, ascending.
    fn crossings(&self, [from, to]: [f64; 2], axis: usize, value: f64) -> Vec<f64> {
        let above = |t: f64| self.at(t)[axis] >= value;
        let first = from.floor() as i64 + 1;
        let inner = (first..).map(|i| i as f64).take_while(|t| *t < to);
        let stops: Vec<f64> = std::iter::once(from).chain(inner).chain([to]).collect();
        let sides: Vec<bool> = stops.iter().map(|t| above(*t)).collect();
        (1..stops.len())
            .filter(|i| sides[i - 1] != sides[*i])
            .map(|i| {
                let (mut lo, mut hi) = (stops[i - 1], stops[i]);
                for _ in 0..BISECTIONS {
                    let middle = 0.5 * (lo + hi);
                    if above(middle) == sides[i - 1] { lo = middle } else { hi = middle }
                }
                0.5 * (lo + hi)
            })
            .collect()
    }
}

/// The pieces of a piece in the children of a cell, with the number of the child.
pub(super) fn divide(arcs: &[Arc], piece: &Piece, tree: &Tree, cell: Cell) -> Vec<(usize, Piece)> {
    let arc = &arcs[piece.arc];
    let half = size(cell.level + 1);
    let keys: [u32; 3] = std::array::from_fn(|a| cell.at[a] + half);
    let planes: [f64; 3] = std::array::from_fn(|a| tree.coordinate(a, keys[a]));
    let mut cuts: Vec<(f64, PieceEnd)> = (0..3)
        .flat_map(|axis| {
            let end = PieceEnd::Plane { axis, key: keys[axis] };
            arc.crossings(piece.range, axis, planes[axis]).into_iter().map(move |t| (t, end))
        })
        .collect();
    cuts.sort_by(|a, b| a.0.total_cmp(&b.0));
    cuts.insert(0, (piece.range[0], piece.ends[0]));
    cuts.push((piece.range[1], piece.ends[1]));
    cuts.windows(2)
        .filter(|w| w[1].0 > w[0].0)
        .map(|w| {
            let middle = arc.at(0.5 * (w[0].0 + w[1].0));
            let child = (0..3).map(|a| usize::from(middle[a] >= planes[a]) << a).sum();
            (child, Piece { arc: piece.arc, range: [w[0].0, w[1].0], ends: [w[0].1, w[1].1] })
        })
        .collect()
}

/// The pieces with those of a closed arc on both sides of its seam as one.
pub(super) fn joined_at_seams(arcs: &[Arc], pieces: &[Piece]) -> Vec<Piece> {
    let mut pieces = pieces.to_vec();
    let ends = |p: &Piece, k: usize| p.ends[k] == PieceEnd::Seam;
    while let Some(i) = pieces.iter().position(|p| ends(p, 1) && !ends(p, 0)) {
        let arc = pieces[i].arc;
        let Some(j) = pieces.iter().position(|p| p.arc == arc && ends(p, 0) && !ends(p, 1)) else { break };
        let second = pieces[j];
        pieces[i].range[1] = second.range[1] + arcs[arc].length();
        pieces[i].ends[1] = second.ends[1];
        pieces.remove(j);
    }
    pieces
}
