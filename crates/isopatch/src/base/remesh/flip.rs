//! Flips: two faces get the other diagonal of their four corners.

use crate::parallel::Evenly;
use rayon::prelude::*;

use super::{Remesher, TASK};
use crate::base::border::flip_bridges;
use crate::base::shape::largest_angle_cosine;

/// A flip may not turn a face farther than this (cosine) from the normals at its corners.
const FLIP_FACING: f64 = 0.3;

/// Cosine of 110°: corners up to this are no reason for a flip.
const WIDE: f64 = -0.34;

impl Remesher<'_> {
    /// May the edge be flipped, as far as the connectivity and the sides of the box are concerned?
    pub(super) fn can_flip(&self, h: u32) -> bool {
        self.mesh.can_flip(h)
            && !self.clip.as_ref().is_some_and(|c| flip_bridges(&self.mesh, |v| c.sides[v as usize], h))
    }

    /// Widest corner (as a cosine) and worst facing of the two faces at an edge, whose right apex is d, before and after
    /// a flip.
    fn compare_flip(&self, h: u32, d: u32) -> [(f64, f64); 2] {
        let [a, b, c] = self.mesh.corners(h);
        let judge = |faces: [[u32; 3]; 2]| {
            let widest = faces.map(|f| largest_angle_cosine(self.corners(f)));
            let facing = faces.map(|f| self.facing_of(f));
            (widest[0].min(widest[1]), facing[0].min(facing[1]))
        };
        [judge([[a, b, c], [b, a, d]]), judge([[d, c, a], [c, d, b]])]
    }

    /// Flips that bring valences nearer to six.
    pub(super) fn flip_for_valence(&mut self) {
        let mut valence: Vec<i32> = vec![0; self.mesh.vertex_bound()];
        self.mesh.faces().flatten().for_each(|v| valence[v as usize] += 1);
        let edges: Vec<u32> = self.mesh.edges().collect();
        for h in edges {
            let ends = [self.mesh.origin(h), self.mesh.dest(h)].map(|v| v as usize);
            let Some(apexes) = self.mesh.apexes(h).map(|a| a.map(|v| v as usize)) else { continue };
            // Change of Σ (faces − wanted)²: −1 at the ends, +1 at the apexes.
            let surplus = |v: &usize| valence[*v] - self.wanted_faces(*v as u32);
            let gain: i32 = ends.iter().map(|v| 2 * surplus(v) - 1).sum::<i32>()
                - apexes.iter().map(|v| 2 * surplus(v) + 1).sum::<i32>();
            if gain <= 0 || !self.can_flip(h) {
                continue;
            }
            let [before, after] = self.compare_flip(h, apexes[1] as u32);
            // Corners up to 143° may stay as wide as they are.
            const WIDEST: f64 = -0.8;
            let too_wide = after.0 < WIDEST.min(before.0);
            if too_wide || (after.1 < FLIP_FACING && after.1 < before.1) {
                continue;
            }
            self.mesh.flip(h);
            ends.iter().for_each(|v| valence[*v] -= 1);
            apexes.iter().for_each(|v| valence[*v] += 1);
        }
    }

    /// Faces at a vertex whose corners there are 60° wide.
    fn wanted_faces(&self, v: u32) -> i32 {
        match self.sides(v).len() {
            0 => 6,
            1 => 3,
            _ => 2,
        }
    }

    /// Flips that make the widest corner narrower, or faces that lean far lean less, until there is none.
    pub fn flip_for_angle(&mut self) {
        const PASSES: usize = 4;
        for _ in 0..PASSES {
            let mut flips = 0;
            let edges: Vec<u32> = self.mesh.edges().collect();
            let found = edges.into_par_iter().evenly_by(TASK).map(|h| (h, self.is_better_flipped(h)));
            let found: Vec<(u32, bool)> = found.collect();
            // What was found in parallel holds until one of the faces at the edge changes.
            let mut is_stale = vec![false; self.mesh.half_edge_bound() as usize / 3];
            for (h, was_better) in found {
                let sides = [Some(h), self.mesh.twin(h)];
                let faces = sides.into_iter().flatten().map(|h| h as usize / 3);
                let is_better = match faces.clone().any(|f| is_stale[f]) {
                    true => self.is_better_flipped(h),
                    false => was_better,
                };
                if is_better && self.can_flip(h) {
                    self.mesh.flip(h);
                    faces.for_each(|f| is_stale[f] = true);
                    flips += 1;
                }
            }
            if flips == 0 {
                break;
            }
        }
    }

    fn is_better_flipped(&self, h: u32) -> bool {
        // Smaller gains may alternate for ever.
        const GAIN: f64 = 0.02;
        // Cosine of 120°: what a flip against leaning may leave as the widest corner.
        const WIDEST: f64 = -0.5;
        let Some([_, d]) = self.mesh.apexes(h) else { return false };
        let [before, after] = self.compare_flip(h, d);
        let turns = after.1 < before.1 - 0.1 || (after.1 < FLIP_FACING && after.1 < before.1);
        let narrower = before.0 < WIDE && after.0 > before.0 + GAIN && !turns;
        let leaning = before.1 < self.options.sizing.lean.to_radians().cos();
        narrower || (leaning && after.1 > before.1 + GAIN && after.0 > WIDEST.min(before.0))
    }
}
