//! Collapses of edges, the cheapest first.

use std::cmp::Reverse;
use std::collections::BinaryHeap;

use crate::parallel::Evenly;
use rayon::prelude::*;

use super::quadric::Quadric;
use crate::base::border::{Merge, collapse_bridges, larger};
use crate::base::clip::BoxSides;
use crate::base::connectivity::Connectivity;
use crate::geom::{Point3, Vec3};

/// Edges are short that are shorter than this share of another edge of their faces.
const SHORT: f64 = 0.6;
/// Sweeps over all edges in search of them.
const SWEEPS: usize = 4;

/// What collapses need to know about a vertex.
#[derive(Clone, Debug)]
pub(super) struct Vertex {
    pub position: Point3,
    /// The field's unit normal.
    pub normal: Vec3,
    pub quadric: Quadric,
    /// The sides of a box that it lies in; none of a closed mesh.
    pub sides: BoxSides,
    /// Must its edges stay as they are?
    pub is_locked: bool,
}

/// A possible collapse.
///
/// Candidates are compared field by field. Costs are bits of nonnegative numbers, which have the same order.
#[derive(Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
struct Candidate {
    cost: u64,
    /// The smaller one first.
    ends: [u32; 2],
    half_edge: u32,
    /// Sum of the versions of the ends.
    version: u32,
}

/// A mesh, or a part of one, whose edges are collapsed.
pub(super) struct Collapses<'a> {
    pub mesh: Connectivity,
    pub vertices: &'a mut [Vertex],
    /// How far a face may turn from the normals at its corners, as a cosine.
    pub turn_limit: f64,
    /// Grows with every change around a vertex; candidates of older versions are out of date.
    version: Vec<u32>,
    heap: BinaryHeap<Reverse<Candidate>>,
}

impl<'a> Collapses<'a> {
    pub fn new(mesh: Connectivity, vertices: &'a mut [Vertex], turn_limit: f64) -> Self {
        let version = vec![0; vertices.len()];
        Self { mesh, vertices, turn_limit, version, heap: BinaryHeap::new() }
    }

    /// Merges short edges in the order of their numbers until at most `faces` faces are left, or there are no more.
    pub fn merge_short_edges(&mut self, faces: usize) {
        for _ in 0..SWEEPS {
            let before = self.mesh.face_count();
            for h in 0..self.mesh.half_edge_bound() {
                if self.mesh.face_count() <= faces {
                    return;
                }
                if self.mesh.is_half_edge(h) && self.is_short(h) {
                    self.collapse(h);
                }
            }
            if self.mesh.face_count() == before {
                return;
            }
        }
    }

    /// Is an edge much shorter than another of the face to its left?
    fn is_short(&self, h: u32) -> bool {
        let [a, b, c] = self.mesh.corners(h).map(|v| self.vertices[v as usize].position);
        let longest = (c - a).norm_squared().max((c - b).norm_squared());
        (b - a).norm_squared() < SHORT * SHORT * longest
    }

    /// Makes candidates of all edges; a task looks at `task` half edges.
    pub fn fill(&mut self, task: usize) {
        let half_edges = (0..self.mesh.half_edge_bound()).into_par_iter().evenly_by(task);
        let edges = half_edges.filter(|h| self.mesh.is_edge(*h));
        let candidates: Vec<Reverse<Candidate>> = edges.filter_map(|h| self.candidate(h)).collect();
        self.heap = candidates.into();
    }

    /// Costs of the candidates, in no order.
    pub fn costs(&self) -> impl Iterator<Item = u64> + '_ {
        self.heap.iter().filter(|candidate| self.is_current(&candidate.0)).map(|candidate| candidate.0.cost)
    }

    /// Collapses edges in the order of their costs, up to `most`, until at most `faces` faces are left.
    pub fn run(&mut self, faces: usize, most: u64) {
        let mut heap = std::mem::take(&mut self.heap);
        while self.mesh.face_count() > faces
            && let Some(Reverse(candidate)) = heap.peek().copied()
            && candidate.cost <= most
        {
            heap.pop();
            if self.is_current(&candidate)
                && let Some(merged) = self.collapse(self.directed(&candidate))
            {
                heap.extend(self.mesh.ring(merged).filter_map(|h| self.candidate(h)));
            }
        }
        self.heap = heap;
    }

    fn ends(&self, h: u32) -> [usize; 2] {
        [self.mesh.origin(h) as usize, self.mesh.dest(h) as usize]
    }

    fn is_current(&self, candidate: &Candidate) -> bool {
        let h = candidate.half_edge;
        self.mesh.is_half_edge(h) && self.version_of(h) == candidate.version
    }

    /// The half edge of a candidate that leaves the first end, if there is one.
    fn directed(&self, candidate: &Candidate) -> u32 {
        let h = candidate.half_edge;
        let is_first = self.mesh.origin(h) == candidate.ends[0];
        if is_first { h } else { self.mesh.twin(h).unwrap_or(h) }
    }

    fn version_of(&self, h: u32) -> u32 {
        self.ends(h).iter().map(|v| self.version[*v]).sum()
    }

    /// Error and place of the merged vertex; none if it would leave a side of the box.
    fn joint(&self, h: u32) -> Option<(Quadric, Point3)> {
        let [a, b] = self.ends(h).map(|v| &self.vertices[v]);
        if a.is_locked || b.is_locked {
            return None;
        }
        let q = a.quadric.plus(&b.quadric);
        let x = match Merge::of(a.sides, b.sides, self.mesh.is_boundary(h))? {
            Merge::Between => {
                let middle = 0.5 * (a.position + b.position);
                let axis = a.sides.iter().next().map(|s| s.axis);
                axis.map_or_else(|| q.minimum(), |axis| q.minimum_within(axis, middle[axis]))
                    .unwrap_or(middle)
            }
            Merge::AtFirst => a.position,
            Merge::AtSecond => b.position,
        };
        Some((q, x))
    }

    fn candidate(&self, h: u32) -> Option<Reverse<Candidate>> {
        let (q, x) = self.joint(h)?;
        let (a, b) = (self.mesh.origin(h), self.mesh.dest(h));
        let cost = q.at(&x).max(0.0).to_bits();
        Some(Reverse(Candidate {
            cost,
            ends: [a.min(b), a.max(b)],
            half_edge: h,
            version: self.version_of(h),
        }))
    }

    /// Merges the end of a half edge into its origin, if that is allowed; returns the origin.
    fn collapse(&mut self, h: u32) -> Option<u32> {
        let [a, b] = self.ends(h);
        let (quadric, position) = self.joint(h)?;
        let normal = (self.vertices[a].normal + self.vertices[b].normal).normalize();
        if !self.looks_outward(h, &position, &normal)
            || !self.mesh.can_collapse(h)
            || collapse_bridges(&self.mesh, |v| self.vertices[v as usize].sides, h)
        {
            return None;
        }
        self.mesh.collapse(h);
        let sides = larger([a, b].map(|v| self.vertices[v].sides));
        self.vertices[a] = Vertex { position, normal, quadric, sides, is_locked: false };
        // Newer than either, so that no candidate at b becomes current again.
        self.version[a] = self.version[a].max(self.version[b]) + 1;
        Some(a as u32)
    }

    /// Do all faces that survive the collapse to `x` look to the side of their corners' normals?
    fn looks_outward(&self, h: u32, x: &Point3, n: &Vec3) -> bool {
        let (a, b) = (self.mesh.origin(h), self.mesh.dest(h));
        let looks_out = |e: u32| {
            let [_, v, w] = self.mesh.corners(e);
            if [v, w].iter().any(|u| *u == a || *u == b) {
                return true;
            }
            let [v, w] = [v, w].map(|v| &self.vertices[v as usize]);
            let area = (v.position - x).cross(&(w.position - x));
            let least = self.turn_limit * area.norm();
            area.norm_squared() > 0.0 && [n, &v.normal, &w.normal].iter().all(|m| area.dot(m) > least)
        };
        self.mesh.ring(a).all(looks_out) && self.mesh.ring(b).all(looks_out)
    }
}
