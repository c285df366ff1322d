//! The steps from polygons with gradients to a hull.

use super::fit;
use super::middles;
use super::options::{DefaultRule, HybridOptions, Middles, Sheets};
use super::paper_rule;
use super::place::{Placed, placed};
use super::settle::{Near, settle};
use super::single_sheet::{self, Certainty, certainties};
use super::wedge;
use crate::geom::Vec3;
use crate::hull::{Problem, Side};
use crate::hybrid::{Element, HermitePolygons, HybridEdge, HybridFace, HybridHull, Quadric, star};
use crate::mesh::{EdgeId, FaceId};
use crate::parallel::Evenly;
use rayon::prelude::*;

/// A hull, and what is known of it.
#[derive(Clone, Debug)]
pub struct BuiltHull {
    /// The hull.
    pub hull: HybridHull,
    /// Cells that are out of order: faces, then edges.
    pub problems: Vec<Problem>,
    /// For every face, what is certain of the rays over it and over its edges.
    pub certainty: Vec<Certainty>,
}

/// Builds the hull of a polygon mesh: classes, cells over the polygons, apexes, and free parameters.
///
/// Linear in the number of corners. Faces that are zero convex are their own patches.
pub fn build(mut data: HermitePolygons, options: &HybridOptions) -> BuiltHull {
    let count = data.mesh().face_count();
    let quadrics: Vec<Quadric> =
        (0..count).into_par_iter().evenly().map(|f| fit::near_face(&data, f.into())).collect();
    if options.middles == Middles::Fitted {
        middles::refine(&mut data, &quadrics);
    }
    let mut faces: Vec<Placed> =
        (0..count).into_par_iter().evenly().map(|f| placed(&data, f.into(), options)).collect();
    if options.adaptive {
        settle(&Near { data: &data, quadrics: &quadrics }, &mut faces);
    }
    let problems = problems(&data, &faces);
    let edges = data.mesh().edges().map(|e| edge(&data, &faces, e)).collect();
    let faces = (0..count)
        .into_par_iter()
        .evenly()
        .map(|f| {
            let face = face(&faces[f], quadrics[f]);
            if options.middles == Middles::Mean || face.element != Some(Element::Sectors) {
                return face;
            }
            let frame = data.frame(f.into());
            let mean = frame.n.iter().sum::<Vec3>() / frame.count() as f64;
            let trust = middles::trust(frame.n.iter().copied(), &mean);
            HybridFace { quadric: star::centered(&frame, &face, trust), ..face }
        })
        .collect();
    let all: Vec<FaceId> = data.mesh().faces().collect();
    let mut hull = HybridHull { data, faces, edges };
    if let DefaultRule::Paper { linear } = options.rule {
        use_paper_rule(&mut hull, linear);
    }
    match options.sheets {
        Sheets::Everywhere => _ = single_sheet::enforce(&mut hull, &all),
        Sheets::OffQuadrics => {
            let free = |f: &FaceId| !fit::is_quadric(&hull.data, *f, &quadrics[f.index()]);
            let chosen: Vec<FaceId> = all.into_par_iter().evenly().filter(free).collect();
            single_sheet::enforce(&mut hull, &chosen);
        }
        Sheets::Nowhere => {}
    }
    let certainty = certainties(&hull);
    BuiltHull { hull, problems, certainty }
}

fn face(placed: &Placed, quadric: Quadric) -> HybridFace {
    HybridFace {
        class: placed.class,
        element: placed.element,
        center: placed.center,
        normal: placed.direction,
        apexes: placed.apexes(),
        at_apex: [None; 2],
        quadric,
    }
}

fn use_paper_rule(hull: &mut HybridHull, linear: bool) {
    for f in 0..hull.faces.len() {
        let frame = hull.data.frame(f.into());
        if let Some((side, jet)) = paper_rule::at_apex(&frame, &hull.faces[f], linear) {
            hull.faces[f].at_apex[side.index()] = Some(jet);
        }
    }
}

fn edge(data: &HermitePolygons, faces: &[Placed], e: EdgeId) -> HybridEdge {
    let class = data.edge_class(data.mesh().edge_half_edge(e));
    let both = data.joint(e).map(|pair| pair.map(|h| faces[data.mesh().face(h).index()].apexes()));
    let has_cell = |side: Side| both.is_some_and(|both| both.iter().all(|a| a[side.index()].is_some()));
    HybridEdge { class, cells: Side::BOTH.map(has_cell) }
}

fn problems(data: &HermitePolygons, faces: &[Placed]) -> Vec<Problem> {
    let mesh = data.mesh();
    let of_face = |f: FaceId| Some(Problem::Face { face: f, reason: faces[f.index()].fault? });
    let of_edge = |e: EdgeId| {
        let pair = data.joint(e)?;
        let class = data.edge_class(pair[0]);
        let cells = Side::BOTH.into_iter().filter(|side| class.reaches(*side));
        let reason = cells.filter_map(|side| wedge::fault(&wedge::cell(data, faces, e, side)?)).min()?;
        Some(Problem::Edge { edge: e, faces: pair.map(|h| mesh.face(h)), reason })
    };
    mesh.faces().filter_map(of_face).chain(mesh.edges().filter_map(of_edge)).collect()
}
