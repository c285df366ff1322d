//! Smooth surfaces by the way of singular ones: the same topology as the base mesh of splines.
#![allow(clippy::unwrap_used, clippy::panic, reason = "a test that fails by a panic is a test that fails")]

use isopatch::base::{BaseOptions, build, find_box};
use isopatch::gallery;
use isopatch::singular::mesh::{TriangulateOptions, triangulate};
use isopatch::singular::{SingularOptions, singular_set};
use std::collections::{BTreeMap, BTreeSet};

/// Euler number, connected parts, closed lines of the border.
fn topology(triangles: &[[u32; 3]]) -> (i64, usize, usize) {
    let mut edges: BTreeMap<[u32; 2], usize> = BTreeMap::new();
    for t in triangles {
        for k in 0..3 {
            let (a, b) = (t[k], t[(k + 1) % 3]);
            *edges.entry([a.min(b), a.max(b)]).or_default() += 1;
        }
    }
    let vertices: BTreeSet<u32> = triangles.iter().flatten().copied().collect();
    let euler = vertices.len() as i64 - edges.len() as i64 + triangles.len() as i64;
    let border = edges.iter().filter(|(_, count)| **count == 1).map(|(ends, _)| *ends);
    (euler, parts(edges.keys().copied()), parts(border))
}

/// Sets of vertices that hang together by edges.
fn parts(edges: impl Iterator<Item = [u32; 2]>) -> usize {
    let mut neighbours: BTreeMap<u32, Vec<u32>> = BTreeMap::new();
    for [a, b] in edges {
        neighbours.entry(a).or_default().push(b);
        neighbours.entry(b).or_default().push(a);
    }
    let mut seen = BTreeSet::new();
    let mut count = 0;
    for start in neighbours.keys() {
        let mut open = vec![*start];
        count += usize::from(!seen.contains(start));
        while let Some(v) = open.pop() {
            if seen.insert(v) {
                open.extend(&neighbours[&v]);
            }
        }
    }
    count
}

#[test]
fn smooth_surfaces_have_the_topology_of_the_splines_base_mesh() {
    let names = ["sphere", "tangle", "dtorus", "orthocircles", "chair", "goursat", "ringcyclide", "clebsch"];
    for name in names {
        let entry = gallery::surface(name).unwrap_or_else(|| panic!("{name}"));
        let formula = entry.field().unwrap();
        let bounds = entry.bounds.map_or_else(|| find_box(&formula), Ok).unwrap();
        let set = singular_set(&formula, &bounds, &SingularOptions::default())
            .unwrap_or_else(|e| panic!("{name}: {e}"));
        assert!(set.is_empty() && set.undecided.is_empty(), "{name}: {set:?}");
        let degree = formula.quadratic_polynomial().unwrap().degree();
        let made = triangulate(&formula, degree, &set, &bounds, &TriangulateOptions::default()).unwrap();
        let base = build(&formula, &bounds, &BaseOptions::default()).unwrap().base;
        let faces: Vec<[u32; 3]> =
            base.mesh.faces().map(|f| base.mesh.triangle(f).map(|v| v.index() as u32)).collect();
        assert_eq!(topology(&made.mesh.triangles), topology(&faces), "{name}");
    }
}
