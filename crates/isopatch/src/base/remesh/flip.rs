//! Flips: two faces get the other diagonal of their four corners.

use crate::parallel::Evenly;
use rayon::prelude::*;

use super::{Remesher, SizingOptions, TASK};
use crate::base::border::flip_bridges;
use crate::base::shape::largest_angle_cosine;

/// A flip may not turn a face farther than this (cosine) from the normals at its corners.
const FLIP_FACING: f64 = 0.3;

/// Cosine of 110°: corners up to this are no reason for a flip.
const WIDE: f64 = -0.34;

/// How wide a face's corners are, and how far it leans; of two faces the worse of both.
struct Form {
    /// Cosine of the widest corner.
    widest: f64,
    /// Least cosine between the face's normal and those at its corners.
    facing: f64,
}

impl Form {
    fn is_wide(&self) -> bool {
        self.widest < WIDE
    }

    fn leans(&self, options: &SizingOptions) -> bool {
        self.facing < options.lean.to_radians().cos()
    }
}

impl Remesher<'_> {
    /// May the edge be flipped, as far as the connectivity and the sides of the box are concerned?
    pub(super) fn can_flip(&self, h: u32) -> bool {
        self.mesh.can_flip(h)
            && !self.clip.as_ref().is_some_and(|c| flip_bridges(&self.mesh, |v| c.sides[v as usize], h))
    }

    /// The two faces at an edge, whose right apex is d, before and after a flip.
    fn faces_of_flip(&self, h: u32, d: u32) -> [[[u32; 3]; 2]; 2] {
        let [a, b, c] = self.mesh.corners(h);
        [[[a, b, c], [b, a, d]], [[d, c, a], [c, d, b]]]
    }

    fn form(&self, face: [u32; 3]) -> Form {
        Form { widest: largest_angle_cosine(self.corners(face)), facing: self.facing_of(face) }
    }

    fn worst_form(&self, faces: [[u32; 3]; 2]) -> Form {
        let [a, b] = faces.map(|f| self.form(f));
        Form { widest: a.widest.min(b.widest), facing: a.facing.min(b.facing) }
    }

    /// Flips that bring valences nearer to six.
    pub(super) fn flip_for_valence(&mut self) {
        let mut valence: Vec<i32> = vec![0; self.mesh.vertex_bound()];
        self.mesh.faces().flatten().for_each(|v| valence[v as usize] += 1);
        let edges = self.mesh.edges();
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
            let [before, after] = self.faces_of_flip(h, apexes[1] as u32).map(|faces| self.worst_form(faces));
            // Corners up to 143° may stay as wide as they are.
            const WIDEST: f64 = -0.8;
            let too_wide = after.widest < WIDEST.min(before.widest);
            if too_wide || (after.facing < FLIP_FACING && after.facing < before.facing) {
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
        (0..PASSES).take_while(|_| self.flip_for_angle_once() > 0).for_each(drop);
    }

    /// One pass of [`Self::flip_for_angle`] over all edges; the number of flips.
    pub(super) fn flip_for_angle_once(&mut self) -> usize {
        // Only flips of poor faces gain something, or of those that are new.
        let faces = self.mesh.faces_in_parallel().evenly_by(TASK);
        let is_poor: Vec<bool> = faces.map(|face| self.is_poor(&self.form(face))).collect();
        let edges = self.mesh.edges();
        let gains = |h: &u32| self.has_side(*h, &is_poor) && self.is_better_flipped(*h);
        let gains: Vec<bool> = edges.par_iter().evenly_by(TASK).map(gains).collect();
        let mut is_new = vec![false; is_poor.len()];
        let mut flips = 0;
        for (h, gains) in edges.into_iter().zip(gains) {
            let gains = if self.has_side(h, &is_new) { self.is_better_flipped(h) } else { gains };
            if gains && self.can_flip(h) {
                self.mesh.flip(h);
                self.sides_of(h).for_each(|f| is_new[f] = true);
                flips += 1;
            }
        }
        flips
    }

    /// The faces at an edge.
    fn sides_of(&self, h: u32) -> impl Iterator<Item = usize> + use<> {
        [Some(h), self.mesh.twin(h)].into_iter().flatten().map(|h| h as usize / 3)
    }

    /// Is one of the faces at an edge marked?
    fn has_side(&self, h: u32, is_marked: &[bool]) -> bool {
        self.sides_of(h).any(|f| is_marked[f])
    }

    pub(super) fn is_better_flipped(&self, h: u32) -> bool {
        // Smaller gains may alternate for ever.
        const GAIN: f64 = 0.02;
        // Cosine of 120°: what a flip against leaning may leave as the widest corner.
        const WIDEST: f64 = -0.5;
        let Some([_, d]) = self.mesh.apexes(h) else { return false };
        let [faces, flipped] = self.faces_of_flip(h, d);
        let before = self.worst_form(faces);
        if !self.is_poor(&before) {
            return false;
        }
        let after = self.worst_form(flipped);
        let turns = after.facing < before.facing - 0.1
            || (after.facing < FLIP_FACING && after.facing < before.facing);
        let narrower = before.is_wide() && after.widest > before.widest + GAIN && !turns;
        let leans_less = before.leans(&self.options.sizing) && after.facing > before.facing + GAIN;
        narrower || (leans_less && after.widest > WIDEST.min(before.widest))
    }

    /// Is there a reason for a flip?
    fn is_poor(&self, form: &Form) -> bool {
        form.is_wide() || form.leans(&self.options.sizing)
    }
}
