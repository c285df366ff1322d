//! One orientation for each component, and the right one for those that are closed.

use super::degenerate::area_vector;
use super::nesting::{Nesting, nesting};
use super::polygons::{Edges, NONE, Polygons};
use super::repairs::{Log, Place, RepairKind};
use crate::geom::Point3;

/// The components of a surface, and how their faces are oriented relative to each other.
#[derive(Clone, Debug)]
pub(super) struct Flood {
    /// Component of each face, from 0 in the order of their first faces.
    pub component: Vec<u32>,
    /// Must the face be turned over to agree with most faces of its component?
    pub turned: Vec<bool>,
    /// First face of each component.
    pub first: Vec<u32>,
    /// Half edges, one of a pair, across which the faces can't agree.
    pub torn: Vec<u32>,
}

impl Flood {
    /// Number of components.
    pub fn count(&self) -> usize {
        self.first.len()
    }
}

/// Spreads the orientation of the first face of each component across pairs of half edges. Linear time.
pub(super) fn flood(face_count: usize, edges: &Edges, mate: &[u32]) -> Flood {
    let mut first_half_edge = vec![NONE; face_count];
    for h in (0..edges.half_edge_count()).rev() {
        first_half_edge[edges.face[h] as usize] = h as u32;
    }
    let mut found = Flood {
        component: vec![NONE; face_count],
        turned: vec![false; face_count],
        first: Vec::new(),
        torn: Vec::new(),
    };
    let mut faces: Vec<u32> = Vec::new();
    for seed in 0..face_count {
        if found.component[seed] != NONE {
            continue;
        }
        let component = found.first.len() as u32;
        found.component[seed] = component;
        found.first.push(seed as u32);
        faces.clear();
        faces.push(seed as u32);
        let mut reached = 0;
        while let Some(f) = faces.get(reached).copied() {
            reached += 1;
            let first = first_half_edge[f as usize];
            let mut h = first;
            loop {
                visit(h, edges, mate, &mut found, &mut faces);
                h = edges.next[h as usize];
                if h == first {
                    break;
                }
            }
        }
        keep_majority(&faces, &mut found.turned);
    }
    found
}

fn visit(h: u32, edges: &Edges, mate: &[u32], found: &mut Flood, faces: &mut Vec<u32>) {
    let g = mate[h as usize];
    if g == NONE {
        return;
    }
    let (f, neighbour) = (edges.face[h as usize] as usize, edges.face[g as usize] as usize);
    let turned = found.turned[f] != (edges.ascends(g) == edges.ascends(h));
    if found.component[neighbour] == NONE {
        found.component[neighbour] = found.component[f];
        found.turned[neighbour] = turned;
        faces.push(neighbour as u32);
    } else if found.turned[neighbour] != turned && h < g {
        found.torn.push(h);
    }
}

fn keep_majority(faces: &[u32], turned: &mut [bool]) {
    let count = faces.iter().filter(|f| turned[**f as usize]).count();
    if 2 * count > faces.len() {
        faces.iter().for_each(|f| turned[*f as usize] = !turned[*f as usize]);
    }
}

/// What is known of a component.
#[derive(Clone, Copy, Debug, Default)]
struct Shape {
    is_open: bool,
    is_mixed: bool,
    /// Six times the signed volume, with the faces turned as the flood says.
    volume: f64,
}

/// Which faces must be turned over: those against most of their component, and then all of a closed component whose
/// normals point the wrong way. A pair of half edges whose faces can't agree is taken apart.
///
/// Wrong is: inward, for a component that lies in an even number of others, or in none. A closed component that is
/// oriented consistently and inward in an odd number of others is a void and stays; one that is oriented consistently and
/// outward always stays. One that is oriented inconsistently has no say: it is a void in an odd number of others.
pub(super) fn orient(
    polygons: &Polygons,
    edges: &Edges,
    positions: &[Point3],
    mate: &mut [u32],
    log: &mut Log,
) -> Vec<bool> {
    let mut found = flood(polygons.len(), edges, mate);
    for h in std::mem::take(&mut found.torn) {
        log.note(RepairKind::TornEdge, edges.place(h));
        let g = std::mem::replace(&mut mate[h as usize], NONE);
        if g != NONE {
            mate[g as usize] = NONE;
        }
    }
    let shapes = shapes(polygons, edges, positions, mate, &found);
    let in_question: Vec<bool> =
        shapes.iter().map(|s| !s.is_open && (s.is_mixed || s.volume < 0.0)).collect();
    let closed: Vec<bool> = shapes.iter().map(|s| !s.is_open).collect();
    let nested = nesting(polygons, positions, &found, &closed, &in_question);
    let mut turn = vec![false; found.count()];
    for (c, shape) in shapes.iter().enumerate().filter(|(c, _)| in_question[*c]) {
        let is_void = nested[c] == Nesting::Inside;
        turn[c] = (shape.volume > 0.0) == is_void && shape.volume != 0.0;
        if nested[c] == Nesting::Unknown {
            log.note(RepairKind::UntestedNesting, Place::Face(polygons.source(found.first[c] as usize)));
        }
        if turn[c] && !shape.is_mixed {
            log.note(RepairKind::TurnedComponent, Place::Face(polygons.source(found.first[c] as usize)));
        }
    }
    for f in 0..polygons.len() {
        let c = found.component[f] as usize;
        found.turned[f] ^= turn[c];
        if found.turned[f] && shapes[c].is_mixed {
            log.note(RepairKind::FlippedFace, Place::Face(polygons.source(f)));
        }
    }
    found.turned
}

fn shapes(
    polygons: &Polygons,
    edges: &Edges,
    positions: &[Point3],
    mate: &[u32],
    found: &Flood,
) -> Vec<Shape> {
    let mut shapes = vec![Shape::default(); found.count()];
    for h in (0..edges.half_edge_count()).filter(|h| mate[*h] == NONE) {
        shapes[found.component[edges.face[h] as usize] as usize].is_open = true;
    }
    for (f, (_, corners)) in polygons.iter().enumerate() {
        let c = found.component[f] as usize;
        let origin = positions[polygons.face(found.first[c] as usize)[0] as usize];
        let volume = six_volume(positions, corners, &origin);
        shapes[c].volume += if found.turned[f] { -volume } else { volume };
        shapes[c].is_mixed |= found.turned[f];
    }
    shapes
}

/// Six times the signed volume of the cone from `origin` over a polygon.
pub(super) fn six_volume(positions: &[Point3], corners: &[u32], origin: &Point3) -> f64 {
    area_vector(positions, corners).dot(&(positions[corners[0] as usize] - origin))
}
