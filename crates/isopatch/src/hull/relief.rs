//! What a hull does about patches that turn over: its checks are about cells, this is about the surface in them.

use super::build::altered;
use super::builder::Builder;
use super::corner::{Steps, cut_further, make_corners};
use super::options::RobustApexes;
use super::problem::Reason;
use super::repair;
use super::simplicial_hull::{AddedCrease, Hull};
use crate::mesh::{EdgeId, FaceId, VertexId};
use std::collections::BTreeMap;

/// How far relief has gone.
#[derive(Clone, Debug, Default)]
pub(super) struct Reliefs {
    /// How often the apexes of a face were raised for it.
    raised: BTreeMap<FaceId, usize>,
    /// How finely vertices are cut.
    pub steps: Steps,
}

/// How often apexes are raised before a crease is made, and what their heights are multiplied by.
const RAISES: usize = 4;
const RAISE: f64 = 1.5;

impl Hull {
    /// Changes the hull where the patches over these faces and edges turn over: raises apexes, and if that has not helped, makes
    /// creases and corners. Also says which faces it changed; none if there is nothing left to do, or the rule is the paper's.
    pub fn relieved(self, faces: &[FaceId], edges: &[EdgeId]) -> (Self, Vec<FaceId>) {
        let before = self.faces().to_vec();
        let (hull, changed) = altered(self, |builder, rule| relieve(builder, faces, edges, rule));
        let mut changed = changed.unwrap_or_default();
        // Raising apexes and cutting vertices reaches farther than the faces that it was done for.
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
    for f in &raised {
        let (before, mark) = (builder.score, builder.mark());
        builder.raise_face(*f, RAISE);
        builder.settle(&[*f], rule);
        if builder.score > before {
            let at = builder.data.mesh().triangle(*f);
            at.into_iter().for_each(|v| repair::relax_around(builder, v, rule));
        }
        if builder.score > before {
            builder.roll_back_to(mark);
        }
    }
    changed.extend(&raised);
    let stuck = |f: &FaceId| raised.binary_search(f).is_err();
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

/// The vertices of a face, that whose normal is farthest from the face's first.
fn most_turned(builder: &Builder<'_>, f: FaceId) -> [VertexId; 3] {
    let frame = builder.frame(f);
    let seen = |k: usize| frame.n[k].dot(&frame.normal) / frame.n[k].norm();
    let mut corners = [0, 1, 2];
    corners.sort_by(|a, b| seen(*a).total_cmp(&seen(*b)));
    corners.map(|k| builder.data.mesh().triangle(f)[k])
}
