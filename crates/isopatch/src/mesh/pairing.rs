//! Which two half edges meet in an edge, where more than two could.

use super::degenerate::{area_vector, duplicates};
use super::orient::{Flood, flood};
use super::polygons::{Edges, NONE, Polygons};
use super::repairs::{Log, RepairKind};
use crate::geom::{Point3, Vec3};
use std::f64::consts::TAU;

/// Faces around an edge that are closer than this, in radians, have no order around it.
const SMALLEST_WEDGE: f64 = 1e-9;

/// The partner of every half edge, `NONE` where the surface is open.
///
/// Two faces at an edge are partners. Where more meet, the edges with two faces hold the surface together as sheets:
/// two faces of one sheet are partners (a body with a fin, two bodies that touch along an edge). The faces that remain
/// are partners if they alternate in direction around the edge, two with the body between them; else the sheets end
/// there. Faces at a wall, which is there once for each of two bodies, are paired around the bodies first. Directions are used only in comparison within a sheet, or as most faces of each sheet have them.
pub(super) fn pair(polygons: &Polygons, edges: &Edges, positions: &[Point3], log: &mut Log) -> Vec<u32> {
    let mut mate = vec![NONE; edges.half_edge_count()];
    let mut is_manifold = true;
    for half_edges in edges.iter() {
        match half_edges {
            [g, h] => join(&mut mate, *g, *h),
            _ => is_manifold &= half_edges.len() == 1,
        }
    }
    if is_manifold {
        return mate;
    }
    let sheets = flood(polygons.len(), edges, &mate);
    let areas: Vec<Vec3> = polygons.iter().map(|(_, corners)| area_vector(positions, corners)).collect();
    let mut is_wall = vec![false; polygons.len()];
    duplicates(polygons).iter().flatten().for_each(|f| is_wall[*f] = true);
    for half_edges in edges.iter().filter(|h| h.len() > 2) {
        log.note(RepairKind::CutEdge, edges.place(half_edges[0]));
        let at_wall = half_edges.iter().any(|h| is_wall[edges.face[*h as usize] as usize]);
        if at_wall && pair_around_bodies(half_edges, &areas, edges, positions, &sheets, &mut mate) {
            continue;
        }
        let rest = pair_within_sheets(half_edges, edges, &sheets, &mut mate);
        pair_around_bodies(&rest, &areas, edges, positions, &sheets, &mut mate);
    }
    mate
}

fn join(mate: &mut [u32], g: u32, h: u32) {
    mate[g as usize] = h;
    mate[h as usize] = g;
}

/// Does the half edge ascend, with its face oriented as its sheet?
fn ascends(h: u32, edges: &Edges, sheets: &Flood) -> bool {
    edges.ascends(h) != sheets.turned[edges.face[h as usize] as usize]
}

/// Pairs the half edges that are the only two of their sheet, and of opposite direction; returns the others.
fn pair_within_sheets(half_edges: &[u32], edges: &Edges, sheets: &Flood, mate: &mut [u32]) -> Vec<u32> {
    let sheet = |h: &u32| sheets.component[edges.face[*h as usize] as usize];
    let mut sorted = half_edges.to_vec();
    sorted.sort_by_key(sheet);
    let mut rest = Vec::new();
    for group in sorted.chunk_by(|g, h| sheet(g) == sheet(h)) {
        match group {
            [g, h] if ascends(*g, edges, sheets) != ascends(*h, edges, sheets) => join(mate, *g, *h),
            _ => rest.extend_from_slice(group),
        }
    }
    rest
}

/// Pairs half edges that alternate in direction around their edge; says whether they do.
///
/// Looking against the edge's direction d, a face in direction t whose half edge runs along d has its outward normal
/// d × t counter-clockwise of it, hence the body clockwise; its partner is the next face there. Of two faces at one
/// angle, that one comes first counter-clockwise: their bodies are on either side.
fn pair_around_bodies(
    half_edges: &[u32],
    areas: &[Vec3],
    edges: &Edges,
    positions: &[Point3],
    sheets: &Flood,
    mate: &mut [u32],
) -> bool {
    let count = half_edges.len();
    if count == 0 || count % 2 == 1 {
        return false;
    }
    let Some(mut around) = angles(half_edges, areas, edges, positions) else { return false };
    around.sort_by(|a, b| a.0.total_cmp(&b.0).then(a.1.cmp(&b.1)));
    let along = |(_, h): (f64, u32)| ascends(h, edges, sheets);
    let before = |i: usize| (i + count - 1) % count;
    let wedge = |from: (f64, u32), to: (f64, u32)| (to.0 - from.0).rem_euclid(TAU);
    for i in 0..count {
        let (a, b) = (around[before(i)], around[i]);
        if wedge(a, b) < SMALLEST_WEDGE && along(b) && !along(a) {
            around.swap(before(i), i);
        }
    }
    let alternate = (0..count).all(|i| along(around[i]) != along(around[before(i)]));
    let bodies = || (0..count).filter(|i| along(around[*i])).map(|i| (around[before(i)], around[i]));
    if !alternate || bodies().any(|(a, b)| wedge(a, b) < SMALLEST_WEDGE) {
        return false;
    }
    bodies().for_each(|(a, b)| join(mate, a.1, b.1));
    true
}

/// The angle of each half edge's face around the edge, with the half edge; none if the edge or a face has no extent.
fn angles(
    half_edges: &[u32],
    areas: &[Vec3],
    edges: &Edges,
    positions: &[Point3],
) -> Option<Vec<(f64, u32)>> {
    let [a, b] = edges.ends(half_edges[0]).map(|v| positions[v as usize]);
    let axis = (b - a).try_normalize(0.0)?;
    let across = axis.cross(&Vec3::ith(axis.iamin(), 1.0)).try_normalize(0.0)?;
    let third = axis.cross(&across);
    let angle = |h: u32| {
        let area = areas[edges.face[h as usize] as usize];
        // The area vector belongs to the face as it is listed, and with it the direction of the half edge.
        let direction = if edges.ascends(h) { axis } else { -axis };
        let inward = area.cross(&direction).try_normalize(0.0)?;
        Some((inward.dot(&third).atan2(inward.dot(&across)), h))
    };
    half_edges.iter().map(|h| angle(*h)).collect()
}
