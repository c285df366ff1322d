//! What a hull does about patches that turn over: its checks are about cells, this is about the surface in them.

use super::build::{altered, built};
use super::builder::Builder;
use super::corner::{Steps, cut_further, make_corners};
use super::options::RobustApexes;
use super::problem::Reason;
use super::refine::Refinement;
use super::simplicial_hull::{AddedCrease, Hull};
use super::{refine, relax, repair};
use crate::mesh::{EdgeId, FaceId, VertexId};
use std::collections::BTreeMap;

/// How far relief has gone.
#[derive(Clone, Debug, Default)]
pub(super) struct Reliefs {
    /// How often the apexes of a face were raised for it.
    raised: BTreeMap<FaceId, usize>,
    /// How often the patches over faces and edges have turned over.
    faces: BTreeMap<FaceId, usize>,
    edges: BTreeMap<EdgeId, usize>,
    /// What is left of the effort that relaxing may take.
    pub effort: usize,
    /// How finely vertices are cut.
    pub steps: Steps,
}

impl Reliefs {
    /// What remains of it after refinement, for which edges have other numbers and some faces are other ones.
    pub fn forget(&mut self, is_new: &impl Fn(&FaceId) -> bool) {
        self.edges.clear();
        self.faces.retain(|f, _| !is_new(f));
        self.raised.retain(|f, _| !is_new(f));
    }

    /// How much better than valid a face is wanted to be.
    pub fn wish_of_face(&self, f: FaceId) -> f64 {
        self.faces.get(&f).map_or(0.0, |n| *n as f64)
    }

    /// How much better than valid an edge is wanted to be.
    pub fn wish_of_edge(&self, e: EdgeId) -> f64 {
        self.edges.get(&e).map_or(0.0, |n| *n as f64)
    }
}

/// How often apexes are raised before a crease is made, and what their heights are multiplied by.
const RAISES: usize = 10;
const RAISE: f64 = 1.5;

/// Height in radii of the face above which apexes are not raised.
const HIGHEST: f64 = 100.0;

impl Hull {
    /// The hull of the given mesh as it is without refinement; none if nothing was refined.
    pub fn unrefined(&self) -> Option<Self> {
        let given = self.refinement.given.as_ref().filter(|_| !self.refinement.faces.is_empty())?;
        let refinement = Refinement { is_off: true, ..Refinement::default() };
        Some(built(given.as_ref().clone(), &self.options, refinement))
    }

    /// Changes the hull where the patches over these faces and edges turn over: raises apexes, and if that has not helped, makes
    /// creases and corners. Also says which faces it changed; none if there is nothing left to do, or the rule is the paper's.
    pub fn relieved(self, faces: &[FaceId], edges: &[EdgeId]) -> (Self, Vec<FaceId>) {
        let before = self.faces().to_vec();
        let (hull, changed) = altered(self, |builder, rule| relieve(builder, faces, edges, rule));
        let mut changed = changed.unwrap_or_default();
        // After refinement, all.
        // Raising apexes and cutting vertices reaches farther than the faces that it was done for.
        if before.len() != hull.faces().len() {
            return (hull, changed);
        }
        let moved =
            before.iter().zip(hull.faces()).enumerate().filter(|(_, (before, after))| before != after);
        changed.extend(moved.map(|(f, _)| FaceId::from(f)));
        changed.sort_unstable();
        changed.dedup();
        (hull, changed)
    }
}

fn relieve(
    builder: &mut Builder<'_>,
    faces: &[FaceId],
    edges: &[EdgeId],
    rule: &RobustApexes,
) -> Vec<FaceId> {
    let mut changed = Vec::new();
    let beside = |builder: &Builder<'_>, e: EdgeId| {
        builder.data.joint(e).map(|pair| pair.map(|h| builder.data.mesh().face(h)))
    };
    let mut raised: Vec<FaceId> = faces.to_vec();
    raised.extend(edges.iter().filter_map(|e| beside(builder, *e)).flatten());
    raised.sort_unstable();
    raised.dedup();
    raised.retain(|f| {
        let count = builder.reliefs.raised.entry(*f).or_insert(0);
        *count += 1;
        *count <= RAISES
    });
    faces.iter().for_each(|f| *builder.reliefs.faces.entry(*f).or_insert(0) += 1);
    edges.iter().for_each(|e| *builder.reliefs.edges.entry(*e).or_insert(0) += 1);
    for cluster in repair::clusters_of(builder, &raised) {
        let odd = cluster.iter().any(|f| builder.reliefs.raised.get(f).is_some_and(|n| n % 2 == 1));
        if odd {
            relax::loosen(builder, &cluster, rule);
            continue;
        }
        let (before, mark) = (builder.score, builder.mark());
        let refined = !builder.refinement.faces.is_empty();
        let low = |f: &FaceId| {
            let frame = builder.frame(*f);
            let longest = (0..3).map(|k| (frame.p[(k + 1) % 3] - frame.p[k]).norm()).fold(0.0, f64::max);
            let most = HIGHEST * frame.inner_radius;
            let most = if refined { most.max(10.0 * longest) } else { most };
            builder.faces[f.index()].heights.iter().all(|h| *h < most)
        };
        let low: Vec<FaceId> = cluster.iter().copied().filter(low).collect();
        low.iter().for_each(|f| builder.raise_face(*f, RAISE));
        builder.settle(&cluster, rule);
        if builder.score > before {
            relax::relax_here(builder, &cluster, rule);
        }
        if builder.score > before {
            builder.roll_back_to(mark);
        }
    }
    changed.extend(&raised);
    let stuck = |f: &FaceId| raised.binary_search(f).is_err();
    if rule.corners && refine_where_stuck(builder, faces, edges, &raised, rule) {
        return builder.data.mesh().faces().collect();
    }
    if rule.corners {
        for e in edges {
            let Some(pair) = beside(builder, *e).filter(|pair| pair.iter().any(stuck)) else { continue };
            builder.set(&[*e], &[]);
            builder.place_by_default(&pair, rule);
            builder.added_creases.push(AddedCrease { edge: *e, reason: Reason::Folds });
            changed.extend(pair);
        }
        for f in faces.iter().filter(|f| stuck(f)) {
            if cut_further(builder, &most_turned(builder, *f), Reason::Folds, rule) {
                changed.push(*f);
            }
        }
        make_corners(builder, rule);
    }
    changed.sort_unstable();
    changed.dedup();
    changed
}

/// Refines around the vertices of patches for which apexes were raised often enough.
fn refine_where_stuck(
    builder: &mut Builder<'_>,
    faces: &[FaceId],
    edges: &[EdgeId],
    raised: &[FaceId],
    rule: &RobustApexes,
) -> bool {
    let mesh = builder.data.mesh();
    let stuck = |f: &FaceId| raised.binary_search(f).is_err();
    let mut vertices = Vec::new();
    for e in edges {
        let pair = builder.data.joint(*e).into_iter().flatten();
        if pair.map(|h| mesh.face(h)).any(|f| stuck(&f)) {
            let h = mesh.edge_half_edge(*e);
            let seen = |v: &VertexId| repair::best_visibility(&builder.data, *v);
            vertices.extend(
                [mesh.origin(h), mesh.dest(h)].into_iter().min_by(|a, b| seen(a).total_cmp(&seen(b))),
            );
        }
    }
    vertices.extend(faces.iter().filter(|f| stuck(f)).map(|f| most_turned(builder, *f)[0]));
    let refined = refine::refine_at(builder, vertices, rule);
    if refined {
        repair::repair(builder, rule);
        refine::refine_around_faults(builder, rule);
        make_corners(builder, rule);
    }
    refined
}

/// The vertices of a face, that whose normal is farthest from the face's first.
fn most_turned(builder: &Builder<'_>, f: FaceId) -> [VertexId; 3] {
    let frame = builder.frame(f);
    let seen = |k: usize| frame.n[k].dot(&frame.normal) / frame.n[k].norm();
    let mut corners = [0, 1, 2];
    corners.sort_by(|a, b| seen(*a).total_cmp(&seen(*b)));
    corners.map(|k| builder.data.mesh().triangle(f)[k])
}
