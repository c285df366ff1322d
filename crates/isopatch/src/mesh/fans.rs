//! A vertex for every fan of faces.

use super::polygons::{Edges, Joined, NONE};

/// The vertices of a manifold with the given pairs of half edges.
#[derive(Clone, Debug)]
pub(super) struct Fans {
    /// Vertex of each corner: one of the input's, or a copy, with numbers after those.
    pub vertex: Vec<u32>,
    /// The vertex that each copy is of.
    pub copies: Vec<u32>,
}

impl Fans {
    /// The vertex of the input that each vertex is: itself, and for a copy the one that it is of, unless the fan has a
    /// corner that was another vertex before it was welded (`before_welding` tells by corner and vertex). That one is free
    /// again, as the weld joined nothing.
    pub fn names(&self, vertex_count: usize, before_welding: impl Fn(usize, u32) -> u32) -> Vec<u32> {
        let mut names: Vec<u32> = (0..vertex_count as u32).chain(self.copies.iter().copied()).collect();
        let mut is_split = vec![false; vertex_count];
        self.copies.iter().for_each(|v| is_split[*v as usize] = true);
        let mut first_corner: Vec<Option<usize>> = vec![None; names.len()];
        for (corner, v) in self.vertex.iter().enumerate().rev() {
            first_corner[*v as usize] = Some(corner).filter(|_| is_split[names[*v as usize] as usize]);
        }
        let wanted = |id: usize| first_corner[id].map(|corner| before_welding(corner, names[id]));
        let wanted: Vec<Option<u32>> = (0..names.len()).map(wanted).collect();
        // Only if every fan of a vertex has its own: else one would be without.
        let mut is_free = vec![true; vertex_count];
        let mut is_shared = vec![false; vertex_count];
        for (id, w) in wanted.iter().enumerate().filter_map(|(id, w)| Some((id, (*w)?))) {
            is_shared[names[id] as usize] |= !std::mem::replace(&mut is_free[w as usize], false);
        }
        for (id, w) in wanted.iter().enumerate().filter_map(|(id, w)| Some((id, (*w)?))) {
            if !is_shared[names[id] as usize] {
                names[id] = w;
            }
        }
        names
    }
}

/// Gives every fan of faces around a vertex a vertex of its own. The fan of the first corner keeps the vertex.
pub(super) fn fans(vertex_count: usize, edges: &Edges, mate: &[u32]) -> Fans {
    let mut fan = Joined::new(edges.half_edge_count());
    for h in 0..edges.half_edge_count() as u32 {
        let g = mate[h as usize];
        if g == NONE || g < h {
            continue;
        }
        let (after_h, after_g) = (edges.next[h as usize], edges.next[g as usize]);
        if edges.ascends(g) == edges.ascends(h) {
            fan.join(h, g);
            fan.join(after_h, after_g);
        } else {
            fan.join(h, after_g);
            fan.join(after_h, g);
        }
    }
    let mut is_taken = vec![false; vertex_count];
    let mut vertex = vec![NONE; edges.half_edge_count()];
    let mut copies = Vec::new();
    for corner in 0..edges.half_edge_count() {
        let root = fan.root(corner as u32) as usize;
        if root == corner {
            let v = edges.origin[corner];
            vertex[corner] = if std::mem::replace(&mut is_taken[v as usize], true) {
                copies.push(v);
                (vertex_count + copies.len() - 1) as u32
            } else {
                v
            };
        } else {
            // A root is the smallest corner of its fan, so it has its vertex already.
            vertex[corner] = vertex[root];
        }
    }
    Fans { vertex, copies }
}
