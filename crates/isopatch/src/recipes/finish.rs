//! The last patches to the tolerance, and no more of them than needed: local changes of the base mesh.
//!
//! ```text
//! split what fails ──► collapse by expected errors ──► split what fails ──► collapse, measure, take back what fails
//! ```

use super::patchwork::{MakeError, Patchwork, Workshop};
use super::refine::misses;
use crate::base::{BaseMesh, BaseOptions, Change, Draft, validity};
use crate::inspect::PatchDeviation;
use crate::mesh::{FaceId, VertexId};
use crate::parallel::Evenly;
use rayon::prelude::*;
use std::collections::HashSet;

/// Rounds of splits at most. A round halves what fails, or nearly so, as it splits no two edges beside each other.
const SPLIT_ROUNDS: usize = 24;
/// Splits do not help where the mesh is wrong as a whole: rounds in a row without fewer failures, where more than this share
/// of the faces fail.
const MOST_VAIN: usize = 4;
const MANY_FAILING: f64 = 0.05;
/// Times that edges are split because a curve or a system has no solution.
const REPAIRS: usize = 20;
/// Collapses without patches between them: a collapse is made where the expected error stays below the tolerance by the
/// factor of its stage. Patches are built after each stage, and expectations start from measured errors again.
const STAGES: [f64; 2] = [2.0, 1.5];
/// Rounds of collapses in each stage.
const STAGE_ROUNDS: usize = 20;
/// The error around a collapse grows with this power of the faces' mean area: order six in the length.
const GROWTH_POWER: f64 = 3.0;
/// A stage is the last one if more than this share of the patches fail after it.
const FAILING_SHARE: f64 = 0.03;
/// Rounds of measured collapses at most.
const THIN_ROUNDS: usize = 60;
/// A measured collapse is tried where errors are below the tolerance by this factor: they nearly double on average, but
/// scatter.
const TRIED: f64 = 1.3;
/// Patches that may be built for measured collapses: this many, or this share of those built before.
const LEAST_THINNING: usize = 1_500;
const THINNING_SHARE: f64 = 0.03;
/// Edges that one task looks at.
const TASK: usize = 64;
/// Collapses go on while a round removes at least this share of the faces.
const WORTH: f64 = 0.002;

/// A mesh under local changes, with its patches.
pub(super) struct Finisher<'a> {
    pub workshop: &'a Workshop<'a>,
    pub options: &'a BaseOptions,
    /// Largest distance of a patch that will do, relative to the diagonal.
    pub tolerance: f64,
    /// Largest angle of a patch's normals to those of the zero set that will do, in radians.
    pub normal_tolerance: f64,
    pub draft: Draft<'a>,
    pub work: Patchwork,
    /// Patches built so far.
    pub built: usize,
}

impl Finisher<'_> {
    /// All steps; the last of them are left out if some patches can't be made to keep the tolerance.
    pub fn run(&mut self) -> Result<(), MakeError> {
        if self.split_failing()? {
            self.collapse_by_expectation()?;
            if self.split_failing()? {
                let budget = LEAST_THINNING.max((THINNING_SHARE * self.built as f64) as usize);
                // Its first round changes the mesh nearly everywhere.
                if self.work.patches.len() <= budget {
                    self.thin(budget);
                }
            }
        }
        Ok(())
    }

    fn fails(&self, patch: &PatchDeviation) -> bool {
        misses(patch, self.tolerance) || patch.max_normal_error > self.normal_tolerance
    }

    /// Faces whose patches will not do.
    fn failing(&self, work: &Patchwork) -> Vec<usize> {
        (0..work.patches.len()).filter(|f| self.fails(&work.patches[*f])).collect()
    }

    /// Splits edges of failing faces, and of those beyond the limits of a base mesh, until there are none; does no patch
    /// fail any more?
    pub fn split_failing(&mut self) -> Result<bool, MakeError> {
        let (mut least, mut vain) = (usize::MAX, 0);
        for _ in 0..SPLIT_ROUNDS {
            let mut failing = self.failing(&self.work);
            let violations = validity(&self.work.surface.base, &self.options.limits);
            failing.extend(violations.iter().map(|v| v.face.index()));
            failing.sort_unstable();
            failing.dedup();
            if failing.is_empty() {
                return Ok(true);
            }
            vain = if failing.len() < least { 0 } else { vain + 1 };
            least = least.min(failing.len());
            let many = failing.len() as f64 > MANY_FAILING * self.work.patches.len() as f64;
            if vain > MOST_VAIN && many {
                break;
            }
            if !self.split(failing)? {
                break;
            }
        }
        Ok(self.failing(&self.work).is_empty())
    }

    /// Splits an edge of each of the faces, those with the largest errors first; was there any that could be split?
    pub fn split(&mut self, mut faces: Vec<usize>) -> Result<bool, MakeError> {
        let error = |f: &usize| self.work.patches[*f].max_distance;
        faces.sort_by(|a, b| error(b).total_cmp(&error(a)).then(a.cmp(b)));
        faces.dedup();
        let Some(mut batch) = self.draft.batch() else { return Ok(false) };
        let mut splits = 0;
        for face in faces {
            let h = batch.most_turned_side(face);
            splits += usize::from(batch.split(h));
        }
        if splits > 0 {
            self.build_repaired()?;
        }
        Ok(splits > 0)
    }

    /// Builds everything, in another workshop than before.
    pub fn build_again(&mut self) -> Result<(), MakeError> {
        let base = self.draft.base().map_err(MakeError::Base)?;
        self.work = self.workshop.build(base, self.draft.live_stamps())?;
        self.built += self.work.patches.len();
        Ok(())
    }

    fn rebuilt(&mut self) -> Result<Patchwork, MakeError> {
        let base = self.draft.base().map_err(MakeError::Base)?;
        let (work, built) = self.workshop.rebuild(base, self.draft.live_stamps(), &self.work)?;
        self.built += built;
        Ok(work)
    }

    /// Builds what changed; where a curve or a G1 system has no solution, edges are split first.
    fn build_repaired(&mut self) -> Result<(), MakeError> {
        for _ in 0..REPAIRS {
            match self.rebuilt() {
                Ok(work) => {
                    self.work = work;
                    return Ok(());
                }
                Err(error) if !self.split_at(&error.vertices()) => return Err(error),
                Err(_) => {}
            }
        }
        self.work = self.rebuilt()?;
        Ok(())
    }

    /// Splits an edge of faces at some vertices of the draft; was there any that could be split?
    fn split_at(&mut self, vertices: &[u32]) -> bool {
        let Ok(base) = self.draft.base() else { return false };
        let Some(mut batch) = self.draft.batch() else { return false };
        let mut splits = 0;
        for v in vertices {
            for h in base.mesh.ring(VertexId(*v)) {
                let side = batch.most_turned_side(base.mesh.face(h).index());
                splits += usize::from(batch.split(side));
            }
        }
        splits > 0
    }

    /// Collapses edges where the errors are small, by what they are expected to become.
    fn collapse_by_expectation(&mut self) -> Result<(), MakeError> {
        for margin in STAGES {
            let before = self.draft.face_count();
            self.collapse_unseen(margin);
            if self.draft.face_count() == before {
                break;
            }
            self.build_repaired()?;
            if self.failing(&self.work).len() as f64 > FAILING_SHARE * self.work.patches.len() as f64 {
                break;
            }
        }
        Ok(())
    }

    /// Collapses edges in many rounds without building any patch.
    fn collapse_unseen(&mut self, margin: f64) {
        let measured = self.work.patches.iter().map(|p| p.max_distance);
        // By slot.
        let mut expected = vec![0.0; self.draft.slot_count()];
        self.draft.live().into_iter().zip(measured).for_each(|(slot, error)| expected[slot as usize] = error);
        for _ in 0..STAGE_ROUNDS {
            let errors: Vec<f64> = self.draft.live().iter().map(|slot| expected[*slot as usize]).collect();
            let collapses = self.collapse_apart(&errors, self.tolerance / margin, &HashSet::new());
            for Collapse { change, worst, .. } in &collapses {
                let faces = change.slots().count() as f64;
                let growth = (faces / (faces - 2.0)).powf(GROWTH_POWER);
                change.slots().for_each(|slot| expected[slot as usize] = worst * growth);
            }
            if (2 * collapses.len()) as f64 <= WORTH * errors.len() as f64 {
                return;
            }
        }
    }

    /// Collapses edges that do not touch each other, those between the smallest errors first, none over `limit`.
    fn collapse_apart(&mut self, errors: &[f64], limit: f64, refused: &HashSet<[u32; 2]>) -> Vec<Collapse> {
        let Some(mut batch) = self.draft.batch() else { return Vec::new() };
        let mut candidates: Vec<(f64, u32)> = (batch.edges().into_par_iter().evenly_by(TASK))
            .map(|h| (batch.faces_around(h).map(|f| errors[f]).fold(0.0, f64::max), h))
            .filter(|(worst, h)| {
                *worst <= limit && !refused.contains(&batch.ends(*h)) && !batch.fails_again(*h)
            })
            .collect();
        candidates.par_sort_unstable_by(|a, b| a.0.total_cmp(&b.0).then(a.1.cmp(&b.1)));
        let edges: Vec<u32> = candidates.iter().map(|(_, h)| *h).collect();
        let ends: Vec<[u32; 2]> = edges.iter().map(|h| batch.ends(*h)).collect();
        let made = batch.collapse_in_order(&edges).into_iter();
        made.map(|(i, change)| Collapse { ends: ends[i], change, worst: candidates[i].0 }).collect()
    }

    /// Collapses edges while all patches will do, until `budget` patches have been built for it.
    fn thin(&mut self, budget: usize) {
        let last = self.built + budget;
        let mut refused: HashSet<[u32; 2]> = HashSet::new();
        for _ in 0..THIN_ROUNDS {
            if self.built >= last {
                break;
            }
            let errors: Vec<f64> = self.work.patches.iter().map(|p| p.max_distance).collect();
            let collapses = self.collapse_apart(&errors, self.tolerance / TRIED, &refused);
            if collapses.is_empty() {
                break;
            }
            let kept = self.keep_good(collapses, &mut refused);
            if (2 * kept) as f64 <= WORTH * errors.len() as f64 {
                break;
            }
        }
    }

    /// Builds what changed and takes back what made patches fail; the number of collapses that stay.
    fn keep_good(&mut self, mut collapses: Vec<Collapse>, refused: &mut HashSet<[u32; 2]>) -> usize {
        loop {
            let made = self.rebuilt();
            let (base, suspects) = match &made {
                Ok(work) => {
                    let base = &work.surface.base;
                    (Some(base.clone()), corners(base, &self.failing(work)))
                }
                Err(error) => (self.draft.base().ok(), error.vertices()),
            };
            let is_good = made.is_ok() && suspects.is_empty();
            if let Ok(work) = made {
                self.work = work;
            }
            if is_good || collapses.is_empty() {
                return collapses.len();
            }
            let near = base.map_or_else(HashSet::new, |base| self.slots_around(&base, &suspects));
            let touches = |c: &Collapse| c.change.slots().any(|slot| near.contains(&slot));
            // Nothing near means that no single one is to blame.
            let all = !collapses.iter().any(touches);
            collapses.retain(|collapse| {
                let stays = !all && !touches(collapse);
                if !stays {
                    self.draft.undo(&collapse.change);
                    refused.insert(collapse.ends);
                }
                stays
            });
        }
    }

    /// Slots of the faces around some vertices of the mesh.
    fn slots_around(&self, base: &BaseMesh, vertices: &[u32]) -> HashSet<u32> {
        let live = self.draft.live();
        let faces = |v: &u32| base.mesh.ring(VertexId(*v)).map(|h| base.mesh.face(h).index());
        vertices.iter().flat_map(faces).map(|f| live[f]).collect()
    }
}

/// A collapse that can be taken back.
struct Collapse {
    ends: [u32; 2],
    change: Change,
    /// The largest error around it before.
    worst: f64,
}

/// Corners of some faces.
fn corners(base: &BaseMesh, faces: &[usize]) -> Vec<u32> {
    faces.iter().flat_map(|f| base.mesh.triangle(FaceId::from(*f)).map(|v| v.0)).collect()
}
