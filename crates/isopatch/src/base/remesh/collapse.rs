//! Collapses: the ends of an edge become one vertex.

use super::{LONG, Remesher, TASK};
use crate::base::border::{Merge, collapse_bridges, larger};
use crate::base::shape::{area_vector, unit_or_zero};
use crate::geom::{Mat3, Point3, Vec3};
use crate::parallel::Evenly;
use rayon::prelude::*;

/// Edges shorter than this times the wanted length are collapsed: the edges around are then nearer to it.
pub(super) const SHORT: f64 = 4.0 / 5.0;

/// A collapse may not turn a face farther than this (cosine) from the normal at the merged vertex, and from those of
/// the face's other corners.
const COLLAPSE_FACING: [f64; 2] = [0.5, 0.3];

/// Twice the area of a face over the square of its longest edge: a collapse may not leave less (equilateral: 0.87).
const THINNEST: f64 = 0.12;

/// The vertex that two ends of an edge become.
struct Merged {
    at: Point3,
    normal: Vec3,
    metric: Mat3,
}

impl Remesher<'_> {
    /// Collapses short edges, the shortest first.
    pub(super) fn collapse_short(&mut self) {
        let short = self.edges_by_length(|l| l < SHORT);
        let trials = short.par_iter().evenly_by(TASK).map(|(_, h)| self.merged(*h, LONG));
        let trials: Vec<Option<Merged>> = trials.collect();
        // Vertices that collapses have moved, or have given other faces; a trial stays right while both ends are none of them.
        let mut has_changed = vec![false; self.x.len()];
        for ((_, h), trial) in short.into_iter().zip(trials) {
            if !self.mesh.is_half_edge(h) {
                continue;
            }
            let (a, b) = (self.mesh.origin(h), self.mesh.dest(h));
            let is_out_of_date = has_changed[a as usize] || has_changed[b as usize];
            let merged = match is_out_of_date {
                false => trial,
                true if self.relative_length(h) < SHORT => self.merged(h, LONG),
                true => None,
            };
            if merged.is_some_and(|merged| self.merge(h, merged)) {
                has_changed[a as usize] = true;
                self.mesh.neighbours(a).for_each(|v| has_changed[v as usize] = true);
            }
        }
    }

    /// Merges the ends in their middle, or at the one that lies in more sides of the box, if no edge gets relatively longer than
    /// `longest` and no face turns or thins out; was that so?
    pub(super) fn try_collapse(&mut self, h: u32, longest: f64) -> bool {
        self.merged(h, longest).is_some_and(|merged| self.merge(h, merged))
    }

    /// The vertex that the ends of an edge become; none if an edge would get too long, or a face turned or thin.
    fn merged(&self, h: u32, longest: f64) -> Option<Merged> {
        let (a, b) = (self.mesh.origin(h), self.mesh.dest(h));
        let (i, j) = (a as usize, b as usize);
        let (at, normal) = match Merge::of(self.sides(a), self.sides(b), self.mesh.is_boundary(h))? {
            Merge::Between => {
                (0.5 * (self.x[i] + self.x[j]), unit_or_zero(&(self.normal[i] + self.normal[j])))
            }
            Merge::AtFirst => (self.x[i], self.normal[i]),
            Merge::AtSecond => (self.x[j], self.normal[j]),
        };
        let size = self.size[i].min(self.size[j]);
        let metric = 0.5 * (self.metric[i] + self.metric[j]);
        let is_far = |u: u32| {
            let d = self.point(u) - at;
            d.dot(&(metric * d)).sqrt() > longest * size && u != a && u != b
        };
        let fits = |e: u32| {
            let [_, v, w] = self.mesh.corners(e);
            v == a || v == b || w == a || w == b || self.is_good_face(at, &normal, v, w)
        };
        let is_against_shape = [a, b].iter().any(|v| self.mesh.neighbours(*v).any(is_far))
            || ![a, b].iter().all(|v| self.mesh.ring(*v).all(fits));
        (!is_against_shape).then_some(Merged { at, normal, metric })
    }

    /// Merges the ends of an edge, unless that is against the topology, as it hardly ever is; was it done?
    fn merge(&mut self, h: u32, Merged { at, normal, metric }: Merged) -> bool {
        if !self.mesh.can_collapse(h) {
            return false;
        }
        let [i, j] = [self.mesh.origin(h), self.mesh.dest(h)].map(|v| v as usize);
        if let Some(clip) = &mut self.clip {
            if collapse_bridges(&self.mesh, |v| clip.sides[v as usize], h) {
                return false;
            }
            clip.sides[i] = larger([clip.sides[i], clip.sides[j]]);
        }
        self.mesh.collapse(h);
        self.x[i] = at;
        self.normal[i] = normal;
        self.size[i] = 0.5 * (self.size[i] + self.size[j]);
        self.metric[i] = metric;
        self.relative[i] = 0.5 * (self.relative[i] + self.relative[j]);
        true
    }

    /// Is the triangle (p, v, w), with normal n at p, neither turned away from its normals nor thin?
    fn is_good_face(&self, p: Point3, n: &Vec3, v: u32, w: u32) -> bool {
        let (q, r) = (self.point(v), self.point(w));
        let area = area_vector([p, q, r]);
        let length = area.norm();
        let longest = (q - p).norm_squared().max((r - q).norm_squared()).max((p - r).norm_squared());
        length >= THINNEST * longest
            && area.dot(n) >= COLLAPSE_FACING[0] * length
            && [v, w].iter().all(|u| area.dot(&self.normal[*u as usize]) >= COLLAPSE_FACING[1] * length)
    }
}
