//! The last patches to the tolerance, and no more of them than needed: local changes of the base mesh, each of which is
//! measured.

use super::patchwork::{MakeError, Patchwork, Workshop};
use super::refine::is_bad;
use crate::base::{BaseMesh, BaseOptions, Change, Draft, validity};
use crate::mesh::{FaceId, VertexId};
use std::collections::{HashMap, HashSet};

/// Rounds of splits at most. Each halves what fails, or nearly so.
const SPLIT_ROUNDS: usize = 20;
/// Rounds of collapses at most.
const THIN_ROUNDS: usize = 40;
/// A collapse makes the faces around a fourth larger, and their error, of order five in the length, nearly twice as
/// large: it is tried where that is within the tolerance, and somewhat beyond, as errors scatter.
const COLLAPSE_ERROR: f64 = 1.3;
/// Stages of collapses without building patches in between, and rounds in each.
const BLIND_STAGES: usize = 3;
const BLIND_ROUNDS: usize = 20;
/// They are tried where the expected error is below the tolerance by this factor.
const BLIND_LIMIT: f64 = 4.0;
/// Collapses go on while a round removes at least this share of the faces.
const WORTH: f64 = 0.002;

/// A mesh under local changes, with its patches.
pub(super) struct Finisher<'a> {
    pub workshop: &'a Workshop<'a>,
    pub options: &'a BaseOptions,
    /// Largest distance of a patch that will do, relative to the diagonal.
    pub tolerance: f64,
    pub draft: Draft<'a>,
    pub work: Patchwork,
    /// Patches that may still be built.
    pub budget: usize,
}

impl Finisher<'_> {
    /// Faces whose patches will not do, or that are beyond the limits of a base mesh.
    fn failing(&self, work: &Patchwork) -> Vec<usize> {
        let mut fails: Vec<bool> =
            work.patches.iter().map(|p| is_bad(p) || !(p.max_distance <= self.tolerance)).collect();
        for violation in validity(&work.base, &self.options.limits) {
            fails[violation.face.index()] = true;
        }
        (0..fails.len()).filter(|f| fails[*f]).collect()
    }

    /// Splits edges of failing faces until there are none; are there none?
    pub fn split_failing(&mut self) -> Result<bool, MakeError> {
        for _ in 0..SPLIT_ROUNDS {
            let mut failing = self.failing(&self.work);
            if failing.is_empty() {
                return Ok(true);
            }
            if std::env::var("TRACE").is_ok() {
                let worst = failing.iter().map(|f| self.work.patches[*f].max_distance).fold(0.0, f64::max);
                eprintln!("split: faces {} failing {} worst {worst:.2e} bad {} over {}", self.work.nets.len(), failing.len(), failing.iter().filter(|f| is_bad(&self.work.patches[**f])).count(), failing.iter().filter(|f| self.work.patches[**f].max_distance>self.tolerance).count());
            }
            let error = |f: &usize| self.work.patches[*f].max_distance;
            failing.sort_by(|a, b| error(b).total_cmp(&error(a)).then(a.cmp(b)));
            let Some(mut batch) = self.draft.batch() else { break };
            let mut splits = 0;
            for face in failing {
                let h = batch.most_turned_side(face);
                splits += usize::from(batch.split(h));
            }
            if splits == 0 {
                break;
            }
            self.work = self.rebuilt()?;
        }
        Ok(self.failing(&self.work).is_empty())
    }

    fn rebuilt(&mut self) -> Result<Patchwork, MakeError> {
        let base = self.draft.base().map_err(MakeError::Base)?;
        let (work, built) = self.workshop.rebuild(base, self.draft.live_stamps(), &self.work)?;
        self.budget = self.budget.saturating_sub(built.len());
        Ok(work)
    }

    /// Collapses edges where the errors are small, by what the errors are expected to become, and then divides the
    /// patches that fail.
    pub fn thin_out(&mut self) -> Result<bool, MakeError> {
        for _ in 0..BLIND_STAGES {
            let before = self.work.nets.len();
            self.collapse_unseen();
            if self.draft.face_count() == before {
                break;
            }
            self.work = self.rebuilt()?;
            let failing = self.failing(&self.work).len();
            if std::env::var("TRACE").is_ok() {
                eprintln!("blind: faces {before} -> {} failing {failing} budget {}", self.work.nets.len(), self.budget);
            }
            if failing as f64 > 0.01 * self.work.nets.len() as f64 || self.work.nets.len() as f64 > 0.9 * before as f64 {
                break;
            }
        }
        self.split_failing()
    }

    /// Collapses edges in many rounds without building any patch.
    fn collapse_unseen(&mut self) {
        let mut expected: HashMap<u32, f64> =
            self.draft.live().into_iter().zip(&self.work.patches).map(|(s, p)| (s, p.max_distance)).collect();
        for _ in 0..BLIND_ROUNDS {
            let live = self.draft.live();
            let errors: Vec<f64> = live.iter().map(|s| expected[s]).collect();
            let Some(mut batch) = self.draft.batch() else { return };
            let mut candidates: Vec<(f64, u32)> = batch
                .edges()
                .into_iter()
                .map(|h| (batch.faces_around(h).into_iter().map(|f| errors[f]).fold(0.0, f64::max), h))
                .filter(|(error, _)| BLIND_LIMIT * error <= self.tolerance)
                .collect();
            candidates.sort_unstable_by(|a, b| a.0.total_cmp(&b.0).then(a.1.cmp(&b.1)));
            let mut count = 0;
            for (worst, h) in candidates {
                if let Some(change) = batch.collapse(h) {
                    count += 1;
                    let n = change.slots().count() as f64;
                    let growth = (n / (n - 2.0)).powi(3);
                    change.slots().for_each(|s| {
                        expected.insert(s, worst * growth);
                    });
                }
            }
            if (2 * count) as f64 <= WORTH * live.len() as f64 {
                return;
            }
        }
    }

    /// Collapses edges while all patches will do.
    pub fn thin(&mut self) {
        let mut refused: HashSet<[u32; 2]> = HashSet::new();
        for _ in 0..THIN_ROUNDS {
            let changes = self.collapse_some(&refused);
            if changes.is_empty() || self.budget == 0 {
                changes.iter().for_each(|(_, c)| self.draft.undo(c));
                break;
            }
            let tried = changes.len();
            let kept = self.keep_good(changes, &mut refused);
            if std::env::var("TRACE").is_ok() {
                eprintln!("thin: faces {} tried {tried} kept {kept} budget {}", self.work.nets.len(), self.budget);
            }
            if (2 * kept) as f64 <= WORTH * self.work.nets.len() as f64 {
                break;
            }
        }
    }

    /// Collapses edges that are far from each other, those with the smallest errors first.
    fn collapse_some(&mut self, refused: &HashSet<[u32; 2]>) -> Vec<([u32; 2], Change)> {
        let patches = &self.work.patches;
        let Some(mut batch) = self.draft.batch() else { return Vec::new() };
        let mut candidates: Vec<(f64, u32)> = batch
            .edges()
            .into_iter()
            .map(|h| {
                let worst = batch.faces_around(h).into_iter().map(|f| patches[f].max_distance);
                (worst.fold(0.0, f64::max), h)
            })
            .filter(|(error, h)| COLLAPSE_ERROR * error <= self.tolerance && !refused.contains(&batch.ends(*h)))
            .collect();
        candidates.sort_unstable_by(|a, b| a.0.total_cmp(&b.0).then(a.1.cmp(&b.1)));
        let mut changes = Vec::new();
        for (_, h) in candidates {
            if batch.is_free(h) {
                let ends = batch.ends(h);
                changes.extend(batch.collapse(h).map(|change| (ends, change)));
            }
        }
        changes
    }

    /// Builds what changed and takes back what made patches fail; the number of changes that stay.
    fn keep_good(&mut self, mut changes: Vec<([u32; 2], Change)>, refused: &mut HashSet<[u32; 2]>) -> usize {
        loop {
            let built = self.rebuilt();
            let suspects: Vec<u32> = match &built {
                Ok(work) => corners(&work.base, &self.failing(work)),
                Err(error) => error.vertices(),
            };
            if let (Ok(work), true) = (&built, suspects.is_empty()) {
                self.work = work.clone();
                return changes.len();
            }
            // Without a surface, the mesh is that of the draft.
            let base = match &built {
                Ok(work) => Some(work.base.clone()),
                Err(_) => self.draft.base().ok(),
            };
            let near = base.map_or_else(HashSet::new, |base| self.slots_around(&base, &suspects));
            let before = changes.len();
            changes.retain(|(ends, change)| {
                let stays = !change.slots().any(|s| near.contains(&s));
                if !stays {
                    self.draft.undo(change);
                    refused.insert(*ends);
                }
                stays
            });
            if changes.len() == before {
                if changes.is_empty() {
                    return 0;
                }
                changes.drain(..).for_each(|(_, change)| self.draft.undo(&change));
            }
            if let Ok(work) = built {
                self.work = work;
            }
        }
    }

    /// Slots of the faces around some vertices of the mesh.
    fn slots_around(&self, base: &BaseMesh, vertices: &[u32]) -> HashSet<u32> {
        let live = self.draft.live();
        let faces = |v: &u32| base.mesh.ring(VertexId(*v)).map(|h| base.mesh.face(h).index());
        vertices.iter().flat_map(faces).map(|f| live[f]).collect()
    }
}

/// Corners of some faces.
fn corners(base: &BaseMesh, faces: &[usize]) -> Vec<u32> {
    faces.iter().flat_map(|f| base.mesh.triangle(FaceId::from(*f)).map(|v| v.0)).collect()
}
