//! What is wrong with a mesh, element by element; nothing is changed.

use super::degenerate::{duplicates, has_repeated_corner, is_flat};
use super::fans::{Fans, fans};
use super::orient::{Flood, flood, six_volume};
use super::pairing::pair;
use super::polygons::{Edges, NONE, Polygons};
use super::prepare::scaled;
use super::repairs::Log;
use super::weld::coincident;
use crate::geom::Point3;
use std::fmt;

/// A loop of edges with a face on one side only.
#[derive(Clone, Debug, PartialEq)]
pub struct Hole {
    /// Its vertices, in the direction of the face at the first edge.
    pub vertices: Vec<u32>,
    /// Sum of the lengths of its edges, in model units.
    pub length: f64,
}

/// Faces that hang together by edges.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Component {
    /// The face with the smallest number.
    pub first_face: u32,
    /// Number of faces.
    pub faces: usize,
    /// Has it no hole?
    pub is_closed: bool,
    /// Do all faces agree in orientation?
    pub is_oriented: bool,
    /// The signed volume in cubic model units, if it is closed and oriented: positive if normals point outward.
    pub volume: Option<f64>,
    /// Is it closed and oriented with normals that point inward? So is the surface of a void in another component.
    pub is_inside_out: bool,
}

/// The findings of [`check`]; lists are in ascending order.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct MeshCheck {
    /// Number of vertices.
    pub vertices: usize,
    /// Number of faces.
    pub faces: usize,
    /// Vertices with a coordinate that is infinite or not a number.
    pub not_finite: Vec<u32>,
    /// Pairs of a face and a vertex that it names and that does not exist.
    pub no_such_vertex: Vec<[u32; 2]>,
    /// Faces with a vertex twice, or with fewer than three corners.
    pub repeated_corners: Vec<u32>,
    /// Faces whose corners lie on a line.
    pub flat: Vec<u32>,
    /// Pairs of a face and an earlier one with the same corners.
    pub duplicates: Vec<[u32; 2]>,
    /// Pairs of a vertex and an earlier one with the same coordinates.
    pub coincident: Vec<[u32; 2]>,
    /// Vertices that no face uses.
    pub unused: Vec<u32>,
    /// Ends of edges with more than two faces.
    pub non_manifold_edges: Vec<[u32; 2]>,
    /// Vertices whose faces form several fans, other than the ends of non-manifold edges.
    pub non_manifold_vertices: Vec<u32>,
    /// Ends of edges whose two faces run along them in the same direction.
    pub misoriented_edges: Vec<[u32; 2]>,
    /// Boundary loops, in the order of their first half edges.
    pub holes: Vec<Hole>,
    /// Components, in the order of their first faces.
    pub components: Vec<Component>,
    /// Vertices − edges + faces, where a vertex counts once for each fan and sheets that are to be taken apart count as
    /// such.
    pub euler: i64,
}

impl MeshCheck {
    /// Has no edge a face on one side only?
    pub fn is_closed(&self) -> bool {
        self.holes.is_empty()
    }

    /// Is it an oriented manifold, with or without holes, all of whose vertices have faces?
    pub fn is_oriented_manifold(&self) -> bool {
        self.faces > 0
            && self.not_finite.is_empty()
            && self.no_such_vertex.is_empty()
            && self.repeated_corners.is_empty()
            && self.duplicates.is_empty()
            && self.unused.is_empty()
            && self.non_manifold_edges.is_empty()
            && self.non_manifold_vertices.is_empty()
            && self.misoriented_edges.is_empty()
    }
}

impl fmt::Display for MeshCheck {
    /// One line with the size, and one for each kind of finding that there is.
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let closed = self.components.iter().filter(|c| c.is_closed).count();
        let inside_out = self.components.iter().filter(|c| c.is_inside_out).count();
        write!(f, "{} vertices, {} faces, ", self.vertices, self.faces)?;
        write!(f, "{} components ({closed} closed), Euler number {}", self.components.len(), self.euler)?;
        for (count, what) in [
            (self.not_finite.len(), "vertices that are not finite"),
            (self.no_such_vertex.len(), "corners without a vertex"),
            (self.repeated_corners.len(), "faces with a repeated corner"),
            (self.flat.len(), "faces without area"),
            (self.duplicates.len(), "duplicate faces"),
            (self.coincident.len(), "vertices at the place of another"),
            (self.unused.len(), "vertices without a face"),
            (self.non_manifold_edges.len(), "non-manifold edges"),
            (self.non_manifold_vertices.len(), "non-manifold vertices"),
            (self.misoriented_edges.len(), "edges between faces of opposite orientation"),
            (inside_out, "closed components with normals inward"),
        ] {
            if count > 0 {
                write!(f, "\n{count} {what}")?;
            }
        }
        if !self.holes.is_empty() {
            let longest = self.holes.iter().map(|h| h.length).fold(0.0, f64::max);
            write!(f, "\n{} holes, the longest of length {longest:.6}", self.holes.len())?;
        }
        Ok(())
    }
}

/// Looks for everything that keeps faces from being a closed oriented manifold. Time O(n log n).
///
/// Any input will do. Faces that can't be used (a corner that does not exist or is not finite, a repeated corner) are
/// listed and left out of what follows. Whether the surface goes through itself is not looked for.
pub fn check<F: AsRef<[u32]>>(positions: &[Point3], faces: &[F]) -> MeshCheck {
    let mut found = MeshCheck { vertices: positions.len(), faces: faces.len(), ..MeshCheck::default() };
    let is_finite = |v: u32| positions[v as usize].iter().all(|x| x.is_finite());
    found.not_finite = (0..positions.len() as u32).filter(|v| !is_finite(*v)).collect();
    let usable = usable(positions, faces, &mut found);
    let (scaled, unit) = scaled(positions, &usable);
    found.coincident = coincident(positions, (0..positions.len() as u32).filter(|v| is_finite(*v)), 0.0);
    found.duplicates = duplicates(&usable).iter().map(|pair| pair.map(|f| usable.source(f))).collect();
    found.flat = usable.iter().filter(|(_, c)| is_flat(&scaled, c)).map(|(source, _)| source).collect();
    let edges = Edges::new(&usable);
    found.non_manifold_edges = edges.iter().filter(|h| h.len() > 2).map(|h| edges.ends(h[0])).collect();
    let mate = pair(&usable, &edges, &scaled, &mut Log::default());
    let pairs = || (0..mate.len() as u32).map(|h| (h, mate[h as usize])).filter(|(h, g)| h < g && *g != NONE);
    let same_way = |(h, g): &(u32, u32)| edges.ascends(*h) == edges.ascends(*g);
    found.misoriented_edges = pairs().filter(same_way).map(|(h, _)| edges.ends(h)).collect();
    let fans = fans(positions.len(), &edges, &mate);
    found.non_manifold_vertices = split_vertices(&fans, &found.non_manifold_edges);
    found.holes = holes(positions, &edges, &mate, &fans);
    let flood = flood(usable.len(), &edges, &mate);
    found.components = components(&scaled, unit, &usable, &edges, &mate, &flood);
    let used = positions.len() + fans.copies.len() - found.unused.len();
    found.euler = (used + usable.len() + pairs().count()) as i64 - edges.half_edge_count() as i64;
    found
}

/// The faces that have an edge each between different, finite vertices; notes the others, and vertices without a face.
fn usable<F: AsRef<[u32]>>(positions: &[Point3], faces: &[F], found: &mut MeshCheck) -> Polygons {
    let mut is_bad = vec![false; positions.len()];
    found.not_finite.iter().for_each(|v| is_bad[*v as usize] = true);
    let mut is_used = vec![false; positions.len()];
    let mut usable = Polygons::with_capacity(faces.len(), 3 * faces.len());
    for (f, corners) in faces.iter().enumerate() {
        let (face, corners) = (f as u32, corners.as_ref());
        let missing = corners.iter().filter(|v| **v as usize >= positions.len());
        let before = found.no_such_vertex.len();
        found.no_such_vertex.extend(missing.map(|v| [face, *v]));
        let is_repeated = has_repeated_corner(corners);
        if is_repeated {
            found.repeated_corners.push(face);
        }
        let all_exist = found.no_such_vertex.len() == before;
        if all_exist && !is_repeated && !corners.iter().any(|v| is_bad[*v as usize]) {
            corners.iter().for_each(|v| is_used[*v as usize] = true);
            usable.push(face, corners.iter().copied());
        }
    }
    found.unused = (0..positions.len() as u32).filter(|v| !is_used[*v as usize]).collect();
    usable
}

fn split_vertices(fans: &Fans, non_manifold_edges: &[[u32; 2]]) -> Vec<u32> {
    let mut at_edges: Vec<u32> = non_manifold_edges.iter().flatten().copied().collect();
    at_edges.sort_unstable();
    let mut split: Vec<u32> =
        fans.copies.iter().copied().filter(|v| at_edges.binary_search(v).is_err()).collect();
    split.sort_unstable();
    split.dedup();
    split
}

/// Follows open half edges from fan to fan: a fan that has any has two.
fn holes(positions: &[Point3], edges: &Edges, mate: &[u32], fans: &Fans) -> Vec<Hole> {
    let mut open_at = vec![[NONE; 2]; positions.len() + fans.copies.len()];
    let fan_ends = |h: u32| [h, edges.next[h as usize]].map(|corner| fans.vertex[corner as usize]);
    let open = || (0..mate.len() as u32).filter(|h| mate[*h as usize] == NONE);
    for h in open() {
        for fan in fan_ends(h) {
            let slots = &mut open_at[fan as usize];
            slots[usize::from(slots[0] != NONE)] = h;
        }
    }
    let mut is_seen = vec![false; mate.len()];
    let mut holes = Vec::new();
    for start in open() {
        let mut hole = Hole { vertices: Vec::new(), length: 0.0 };
        let [mut from, _] = fan_ends(start);
        let mut h = start;
        while h != NONE && !std::mem::replace(&mut is_seen[h as usize], true) {
            let [a, b] = [edges.origin[h as usize], edges.dest[h as usize]];
            let [fan_a, fan_b] = fan_ends(h);
            hole.vertices.push(if from == fan_a { a } else { b });
            hole.length += (positions[a as usize] - positions[b as usize]).norm();
            from = if from == fan_a { fan_b } else { fan_a };
            let [g, k] = open_at[from as usize];
            h = if g == h { k } else { g };
        }
        if !hole.vertices.is_empty() {
            holes.push(hole);
        }
    }
    holes
}

/// `positions` are in multiples of `unit`.
fn components(
    positions: &[Point3],
    unit: f64,
    polygons: &Polygons,
    edges: &Edges,
    mate: &[u32],
    flood: &Flood,
) -> Vec<Component> {
    let new = |first: &u32| Component {
        first_face: polygons.source(*first as usize),
        faces: 0,
        is_closed: true,
        is_oriented: true,
        volume: None,
        is_inside_out: false,
    };
    let mut found: Vec<Component> = flood.first.iter().map(new).collect();
    let of = |h: u32| flood.component[edges.face[h as usize] as usize] as usize;
    (0..mate.len() as u32).filter(|h| mate[*h as usize] == NONE).for_each(|h| found[of(h)].is_closed = false);
    flood.torn.iter().for_each(|h| found[of(*h)].is_oriented = false);
    let mut six_volumes = vec![0.0; found.len()];
    for (f, (_, corners)) in polygons.iter().enumerate() {
        let c = flood.component[f] as usize;
        found[c].faces += 1;
        found[c].is_oriented &= !flood.turned[f];
        let origin = positions[polygons.face(flood.first[c] as usize)[0] as usize];
        six_volumes[c] += six_volume(positions, corners, &origin);
    }
    for (component, six_volume) in found.iter_mut().zip(six_volumes) {
        let is_body = component.is_closed && component.is_oriented;
        component.volume = is_body.then_some(six_volume / 6.0 * unit * unit * unit);
        component.is_inside_out = is_body && six_volume < 0.0;
    }
    found
}
