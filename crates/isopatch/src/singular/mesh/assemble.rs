//! Triangles from a partition: roots on the edges of its cells, curves in their faces, discs and cones in the cells.
//!
//! Every vertex and every curve between two cells is computed once, so the mesh has no gaps, whatever is uncertain.

use std::collections::{BTreeMap, BTreeSet, HashMap, HashSet};

use crate::parallel::Evenly;
use rayon::prelude::*;

use super::arcs::{Arc, Piece, PieceEnd};
use super::grid::{Cell, Edge, Face, SPAN, Tree, size};
use super::partition::{Content, Partition, Skeleton};
use super::plane_curve::{Crossing, Links, Node, Pierce, Plane, Rectangle};
use super::project::{onto_curve, onto_surface};
use super::roots::Isolator;
use super::singular_mesh::VertexKind;
use crate::field::Field;
use crate::geom::{Aabb, Point3, Vec3};
use crate::singular::CurveKind;

/// Triangles that are not yet thinned out.
#[derive(Clone, Debug, Default)]
pub(super) struct RawMesh {
    pub(super) positions: Vec<Point3>,
    pub(super) kinds: Vec<VertexKind>,
    pub(super) triangles: Vec<[u32; 3]>,
    /// The cell of each triangle.
    pub(super) cells: Vec<Cell>,
    /// Cells where something is not as expected.
    pub(super) doubtful: BTreeSet<Cell>,
}

/// The field, and how it is solved along lines.
pub(super) struct Solver<'a> {
    pub(super) field: &'a dyn Field,
    pub(super) isolator: Isolator,
}

/// A root on an edge.
#[derive(Clone, Copy, Debug)]
struct Root {
    at: f64,
    vertex: u32,
    rises: bool,
}

/// Where an arc goes through a plane of the grid.
struct Gate {
    cell: Cell,
    axis: usize,
    key: u32,
    vertex: u32,
    kind: CurveKind,
}

/// Parameters of a closed arc that differ by no more are the same, on both sides of where it begins anew.
const SAME_PARAMETER: f64 = 1e-9;

/// Makes the mesh. The vertices of the centres come first, in their order, with the kinds that are given.
pub(super) fn assemble(
    solver: &Solver<'_>,
    skeleton: &Skeleton,
    kinds: &[VertexKind],
    partition: &Partition<'_>,
) -> RawMesh {
    let mut mesh = RawMesh {
        positions: skeleton.centers.iter().map(|c| c.at).collect(),
        kinds: kinds.to_vec(),
        ..RawMesh::default()
    };
    let tree = &partition.tree;
    let leaves = tree.leaves();
    let gates = gates(solver, skeleton, partition, &leaves, &mut mesh);
    let faces_of: Vec<Vec<(Face, bool)>> = leaves
        .par_iter()
        .evenly()
        .map(|cell| {
            let sides = (0..3).flat_map(|axis| [(axis, false), (axis, true)]);
            sides
                .flat_map(|(axis, upper)| tree.faces(*cell, axis, upper).into_iter().map(move |f| (f, upper)))
                .collect()
        })
        .collect();
    let faces: BTreeSet<Face> = faces_of.iter().flatten().map(|(face, _)| *face).collect();
    let faces: Vec<Face> = faces.into_iter().collect();
    let sides: Vec<[Vec<Edge>; 4]> = faces.par_iter().evenly().map(|face| sides(tree, *face)).collect();
    let roots = roots(solver, tree, &sides, &mut mesh);
    let pierces = pierces(skeleton, partition, &leaves, &faces_of, &gates, &mut mesh);
    let unknown = leaves
        .iter()
        .zip(&faces_of)
        .filter(|(cell, _)| !matches!(partition.leaves[*cell], Content::Graph(_)));
    let thorough: HashSet<Face> =
        unknown.flat_map(|(_, faces)| faces.iter().map(|(face, _)| *face)).collect();
    let found: Vec<Links> = faces
        .par_iter()
        .evenly()
        .zip(&sides)
        .map(|(face, sides)| {
            // In faces between graphs a closed curve is a bump, without which the topology is the same.
            curve(solver, tree, *face, sides, &roots, pierces.get(face), thorough.contains(face))
        })
        .collect();
    let curves: HashMap<Face, Curve> = faces
        .iter()
        .zip(&sides)
        .zip(found)
        .map(|((face, _), links)| (*face, with_middles(solver, tree, *face, links, &mut mesh)))
        .collect();
    let mut rims: BTreeMap<u32, usize> = BTreeMap::new();
    for gate in &gates {
        rims.insert(gate.vertex, 0);
    }
    for curve in curves.values() {
        for v in curve.links.iter().flatten() {
            if let Some(count) = rims.get_mut(v) {
                *count += 1;
            }
        }
    }
    for (cell, faces) in leaves.iter().zip(&faces_of) {
        let doubtful = fill(solver, skeleton, partition, *cell, faces, &curves, &mut mesh);
        if doubtful {
            mesh.doubtful.insert(*cell);
        }
    }
    for gate in &gates {
        let expected: &[usize] = match gate.kind {
            CurveKind::Crossing => &[4],
            CurveKind::Cuspidal => &[2],
            CurveKind::Stick => &[0],
            CurveKind::Tangential => &[0, 2, 4, 6, 8],
        };
        let is_end = matches!(mesh.kinds[gate.vertex as usize], VertexKind::Special(_));
        if !is_end && !expected.contains(&rims[&gate.vertex]) {
            mesh.doubtful.insert(gate.cell);
        }
    }
    mesh
}

/// The curve in a face: parts with f > 0 on the left, and whether there is doubt.
#[derive(Clone, Debug, Default)]
struct Curve {
    links: Vec<[u32; 2]>,
    doubtful: bool,
}

/// The vertices where arcs go through planes: one for both cells.
fn gates(
    solver: &Solver<'_>,
    skeleton: &Skeleton,
    partition: &Partition<'_>,
    leaves: &[Cell],
    mesh: &mut RawMesh,
) -> Vec<Gate> {
    let bounds = &partition.tree.bounds;
    let mut known: HashMap<(usize, usize, u32), Vec<(f64, u32)>> = HashMap::new();
    let mut gates = Vec::new();
    for cell in leaves {
        let pieces = match &partition.leaves[cell] {
            Content::Arc(piece) => std::slice::from_ref(piece),
            Content::Center(_, pieces) => pieces,
            Content::Graph(_) | Content::Uncertain => continue,
        };
        for piece in pieces {
            let arc = &skeleton.arcs[piece.arc];
            for (t, end) in piece.range.iter().zip(piece.ends) {
                let PieceEnd::Plane { axis, key } = end else { continue };
                let t = if arc.closed { t.rem_euclid(arc.length()) } else { *t };
                let here = known.entry((piece.arc, axis, key)).or_default();
                let same = here.iter().find(|(other, _)| (t - other).abs() <= SAME_PARAMETER);
                let vertex = match same {
                    Some((_, vertex)) => *vertex,
                    None => {
                        let mut at = arc.at(t);
                        at[axis] = partition.tree.coordinate(axis, key);
                        let vertex = match arc.end_at(t) {
                            Some(special) => mesh.push(at, VertexKind::Special(special as u32)),
                            None => {
                                at = onto_curve(solver.field, at, Some(axis), bounds);
                                mesh.push(at, VertexKind::OnCurve(piece.arc as u32))
                            }
                        };
                        here.push((t, vertex));
                        vertex
                    }
                };
                gates.push(Gate { cell: *cell, axis, key, vertex, kind: arc.kind });
            }
        }
    }
    gates
}

/// Where centres and arcs are in faces.
fn pierces(
    skeleton: &Skeleton,
    partition: &Partition<'_>,
    leaves: &[Cell],
    faces_of: &[Vec<(Face, bool)>],
    gates: &[Gate],
    mesh: &mut RawMesh,
) -> HashMap<Face, Pierce> {
    let tree = &partition.tree;
    let number: HashMap<Cell, usize> = leaves.iter().enumerate().map(|(i, cell)| (*cell, i)).collect();
    let mut found: HashMap<Face, Pierce> = HashMap::new();
    let mut put = |cell: &Cell, axis: usize, key: u32, vertex: u32, mesh: &mut RawMesh| {
        let p = mesh.positions[vertex as usize];
        let faces = faces_of[number[cell]].iter().map(|(face, _)| *face);
        let face = faces.filter(|f| f.axis == axis && f.at[axis] == key).find(|f| {
            let range = range(tree, *f);
            f.plane_axes().iter().zip(range).all(|(a, [lo, hi])| lo <= p[*a] && p[*a] <= hi)
        });
        let Some(face) = face else {
            mesh.doubtful.insert(*cell);
            return;
        };
        let at = face.plane_axes().map(|a| p[a]);
        let previous = found.insert(face, Pierce { at, vertex });
        if previous.is_some_and(|p| p.vertex != vertex) {
            mesh.doubtful.insert(*cell);
        }
    };
    for gate in gates {
        put(&gate.cell, gate.axis, gate.key, gate.vertex, mesh);
    }
    for cell in leaves {
        let Content::Center(c, _) = &partition.leaves[cell] else { continue };
        let at = skeleton.centers[*c].at;
        for (axis, key) in (0..3).flat_map(|axis| [(axis, 0), (axis, SPAN)]) {
            if at[axis] == tree.coordinate(axis, key) {
                put(cell, axis, key, *c as u32, mesh);
            }
        }
    }
    found
}

/// The smallest segments on the four sides of a face, in the order of [`Rectangle::sides`].
fn sides(tree: &Tree, face: Face) -> [Vec<Edge>; 4] {
    let [u, v] = face.plane_axes();
    let far = |axis: usize| {
        let mut at = face.at;
        at[axis] += size(face.level);
        at
    };
    [(u, face.at), (u, far(v)), (v, face.at), (v, far(u))].map(|(axis, at)| {
        let mut found = Vec::new();
        tree.segments(Edge { axis, level: face.level, at }, &mut found);
        found
    })
}

/// The roots on all edges.
fn roots(
    solver: &Solver<'_>,
    tree: &Tree,
    sides: &[[Vec<Edge>; 4]],
    mesh: &mut RawMesh,
) -> HashMap<Edge, Vec<Root>> {
    let edges: BTreeSet<Edge> = sides.iter().flatten().flatten().copied().collect();
    let edges: Vec<Edge> = edges.into_iter().collect();
    let found: Vec<Vec<(f64, bool)>> = edges
        .par_iter()
        .evenly()
        .map(|edge| {
            let start = tree.point(edge.at);
            let end = tree.coordinate(edge.axis, edge.at[edge.axis] + size(edge.level));
            let axes = [(edge.axis + 1) % 3, (edge.axis + 2) % 3, edge.axis];
            let plane =
                Plane { field: solver.field, isolator: &solver.isolator, axes, height: start[axes[0]] };
            // The coordinates of the plane are the axis after the fixed one, and the edge's own.
            plane.on_line(0, start[axes[1]], [start[edge.axis], end])
        })
        .collect();
    let mut roots = HashMap::new();
    for (edge, found) in edges.into_iter().zip(found) {
        let place = |at: f64| {
            let mut p = tree.point(edge.at);
            p[edge.axis] = at;
            p
        };
        let on_edge = found
            .into_iter()
            .map(|(at, rises)| Root { at, vertex: mesh.push(place(at), VertexKind::Regular), rises })
            .collect();
        roots.insert(edge, on_edge);
    }
    roots
}

/// The ranges of the two coordinates of a face.
fn range(tree: &Tree, face: Face) -> [[f64; 2]; 2] {
    face.plane_axes()
        .map(|a| [tree.coordinate(a, face.at[a]), tree.coordinate(a, face.at[a] + size(face.level))])
}

fn curve(
    solver: &Solver<'_>,
    tree: &Tree,
    face: Face,
    sides: &[Vec<Edge>; 4],
    roots: &HashMap<Edge, Vec<Root>>,
    pierce: Option<&Pierce>,
    thorough: bool,
) -> Links {
    let crossings = |edges: &Vec<Edge>| {
        let all = edges.iter().filter_map(|e| roots.get(e)).flatten();
        all.map(|r| Crossing { at: r.at, node: Node::Vertex(r.vertex), rises: r.rises }).collect()
    };
    let rectangle = Rectangle { range: range(tree, face), sides: sides.each_ref().map(crossings) };
    let [u, v] = face.plane_axes();
    let height = tree.coordinate(face.axis, face.at[face.axis]);
    let plane = Plane { field: solver.field, isolator: &solver.isolator, axes: [face.axis, u, v], height };
    plane.links(rectangle, pierce.copied(), thorough)
}

/// Links whose ends are on one straight side of the face get a vertex between them: the chord would run along the side.
fn with_middles(solver: &Solver<'_>, tree: &Tree, face: Face, links: Links, mesh: &mut RawMesh) -> Curve {
    let mut curve = Curve { doubtful: links.doubtful, links: Vec::new() };
    let axes = face.plane_axes();
    let range = range(tree, face);
    let height = tree.coordinate(face.axis, face.at[face.axis]);
    let mut push = |at: &[f64; 2]| {
        let mut p = Point3::zeros();
        p[face.axis] = height;
        (p[axes[0]], p[axes[1]]) = (at[0], at[1]);
        mesh.push(p, VertexKind::Regular)
    };
    for oval in &links.ovals {
        let ring: Vec<u32> = oval.iter().map(&mut push).collect();
        curve.links.extend((0..ring.len()).map(|i| [ring[i], ring[(i + 1) % ring.len()]]));
    }
    let chains: Vec<Vec<u32>> = links
        .links
        .iter()
        .map(|link| {
            let between = link.between.iter().map(&mut push);
            std::iter::once(link.ends[0]).chain(between).chain([link.ends[1]]).collect()
        })
        .collect();
    for chain in chains {
        let [a, b] = chain[..] else {
            curve.links.extend(chain.windows(2).map(|w| [w[0], w[1]]));
            continue;
        };
        let (p, q) = (mesh.positions[a as usize], mesh.positions[b as usize]);
        let Some(side) = (0..2).find(|k| p[axes[*k]] == q[axes[*k]]) else {
            curve.links.push([a, b]);
            continue;
        };
        let plane = Plane {
            field: solver.field,
            isolator: &solver.isolator,
            axes: [face.axis, axes[0], axes[1]],
            height,
        };
        let along = 0.5 * (p[axes[1 - side]] + q[axes[1 - side]]);
        let from = p[axes[side]];
        // `on_line` fixes the first coordinate for 0.
        let nearest = plane
            .on_line(1 - side, along, range[side])
            .into_iter()
            .map(|(at, _)| at)
            .min_by(|a, b| (a - from).abs().total_cmp(&(b - from).abs()));
        let mut middle = p;
        middle[axes[1 - side]] = along;
        middle[axes[side]] = nearest.unwrap_or(from);
        curve.doubtful |= nearest.is_none();
        let m = mesh.push(middle, VertexKind::Regular);
        curve.links.extend([[a, m], [m, b]]);
    }
    curve
}

/// Fills the surface into a cell; true if there is something odd.
fn fill(
    solver: &Solver<'_>,
    skeleton: &Skeleton,
    partition: &Partition<'_>,
    cell: Cell,
    faces: &[(Face, bool)],
    curves: &HashMap<Face, Curve>,
    mesh: &mut RawMesh,
) -> bool {
    let mut links: Vec<[u32; 2]> = Vec::new();
    let mut doubtful = false;
    for (face, upper) in faces {
        let curve = &curves[face];
        doubtful |= curve.doubtful;
        // Seen from outside; the lower sides are seen from behind.
        links.extend(curve.links.iter().map(|[a, b]| if *upper { [*a, *b] } else { [*b, *a] }));
    }
    if links.is_empty() {
        return doubtful;
    }
    let bounds = partition.tree.bounds_of(cell);
    let content = &partition.leaves[&cell];
    let groups = connected(&links);
    let gates: HashSet<u32> =
        links.iter().flatten().copied().filter(|v| mesh.kinds[*v as usize] != VertexKind::Regular).collect();
    let singular = |v: u32| gates.contains(&v);
    let has_gate: Vec<bool> = groups.iter().map(|g| g.iter().flatten().any(|v| singular(*v))).collect();
    let apex = match content {
        Content::Center(c, _) if skeleton.centers[*c].has_sheets => Some(*c as u32),
        Content::Arc(piece) if has_gate.iter().any(|x| *x) => {
            Some(apex(solver, skeleton, piece, partition, mesh))
        }
        _ => None,
    };
    if matches!(content, Content::Arc(_)) && apex.is_some() {
        doubtful |= !run_along(&links, &singular);
    }
    let all = matches!(content, Content::Center(..));
    if let Content::Center(c, _) = content
        && let Some(parts) = skeleton.centers[*c].parts
    {
        doubtful |= groups.len() != parts;
    }
    let mut loops = Vec::new();
    for (group, has_gate) in groups.iter().zip(has_gate) {
        match apex {
            Some(apex) if has_gate || all => {
                let new = group.iter().filter(|ab| !ab.contains(&apex)).map(|[a, b]| [apex, *a, *b]);
                new.for_each(|t| mesh.add(t, cell));
            }
            _ => match as_loop(group) {
                Some(ring) => loops.push(ring),
                None => doubtful = true,
            },
        }
    }
    if let Content::Graph(direction) = content {
        doubtful |= nested(&loops, direction, &mesh.positions);
    }
    for ring in loops {
        doubtful |= !disc(solver, &bounds, cell, &ring, mesh);
    }
    doubtful
}

/// The vertex of an arc in a cell from which the surface is a cone.
fn apex(
    solver: &Solver<'_>,
    skeleton: &Skeleton,
    piece: &Piece,
    partition: &Partition<'_>,
    mesh: &mut RawMesh,
) -> u32 {
    let arc: &Arc = &skeleton.arcs[piece.arc];
    let at = arc.at(0.5 * (piece.range[0] + piece.range[1]));
    let at = onto_curve(solver.field, at, None, &partition.tree.bounds);
    mesh.push(at, VertexKind::OnCurve(piece.arc as u32))
}

/// Does every curve that begins where an arc enters a cell end where it leaves it? Otherwise the surface is no cone.
fn run_along(links: &[[u32; 2]], is_gate: &dyn Fn(u32) -> bool) -> bool {
    let mut next: HashMap<u32, u32> = HashMap::new();
    links.iter().filter(|[a, _]| !is_gate(*a)).for_each(|[a, b]| {
        next.insert(*a, *b);
    });
    links.iter().filter(|[a, _]| is_gate(*a)).all(|[a, b]| {
        let mut end = *b;
        for _ in 0..links.len() {
            match next.get(&end) {
                Some(v) if !is_gate(end) => end = *v,
                _ => break,
            }
        }
        is_gate(end) && end != *a
    })
}

/// The connected parts of a graph.
fn connected(links: &[[u32; 2]]) -> Vec<Vec<[u32; 2]>> {
    let mut number: HashMap<u32, usize> = HashMap::new();
    for v in links.iter().flatten() {
        let next = number.len();
        number.entry(*v).or_insert(next);
    }
    let mut sets = super::sheets::Sets::new(number.len());
    links.iter().for_each(|[a, b]| sets.join(number[a], number[b]));
    let mut groups: BTreeMap<usize, Vec<[u32; 2]>> = BTreeMap::new();
    for link in links {
        groups.entry(sets.root(number[&link[0]])).or_default().push(*link);
    }
    groups.into_values().collect()
}

/// The vertices of a closed chain in order.
fn as_loop(links: &[[u32; 2]]) -> Option<Vec<u32>> {
    let next: HashMap<u32, u32> = links.iter().map(|[a, b]| (*a, *b)).collect();
    let start = links[0][0];
    let mut ring = vec![start];
    while ring.len() <= links.len() {
        let v = *next.get(&ring[ring.len() - 1])?;
        if v == start {
            return (ring.len() == links.len()).then_some(ring);
        }
        ring.push(v);
    }
    None
}

/// Is one of the loops inside another, seen along a direction? Then the graph has a hole.
fn nested(loops: &[Vec<u32>], direction: &Vec3, positions: &[Point3]) -> bool {
    if loops.len() < 2 {
        return false;
    }
    let u = direction.cross(&Vec3::ith(direction.iamin(), 1.0)).normalize();
    let v = direction.cross(&u);
    let flat = |i: &u32| [u.dot(&positions[*i as usize]), v.dot(&positions[*i as usize])];
    let flat: Vec<Vec<[f64; 2]>> = loops.iter().map(|ring| ring.iter().map(flat).collect()).collect();
    let inside = |p: &[f64; 2], ring: &[[f64; 2]]| {
        let crossings = (0..ring.len()).filter(|i| {
            let (a, b) = (ring[*i], ring[(i + 1) % ring.len()]);
            (a[1] > p[1]) != (b[1] > p[1]) && p[0] < a[0] + (p[1] - a[1]) / (b[1] - a[1]) * (b[0] - a[0])
        });
        crossings.count() % 2 == 1
    };
    (0..flat.len()).any(|i| (0..flat.len()).any(|j| i != j && inside(&flat[i][0], &flat[j])))
}

/// Fills a loop; false if the vertex in its middle is not on the surface.
fn disc(solver: &Solver<'_>, bounds: &Aabb, cell: Cell, ring: &[u32], mesh: &mut RawMesh) -> bool {
    if let [a, b, c] = ring[..] {
        mesh.add([a, b, c], cell);
        return true;
    }
    let points: Vec<Point3> = ring.iter().map(|v| mesh.positions[*v as usize]).collect();
    let mean = points.iter().sum::<Point3>() / points.len() as f64;
    let area: Vec3 =
        (0..points.len()).map(|i| (points[i] - mean).cross(&(points[(i + 1) % points.len()] - mean))).sum();
    let center = onto_surface(solver, mean, area, bounds);
    let c = mesh.push(center.unwrap_or(mean), VertexKind::Regular);
    for i in 0..ring.len() {
        mesh.add([c, ring[i], ring[(i + 1) % ring.len()]], cell);
    }
    center.is_some()
}

impl RawMesh {
    fn push(&mut self, at: Point3, kind: VertexKind) -> u32 {
        self.positions.push(at);
        self.kinds.push(kind);
        self.positions.len() as u32 - 1
    }

    fn add(&mut self, triangle: [u32; 3], cell: Cell) {
        self.triangles.push(triangle);
        self.cells.push(cell);
    }
}

/// The cells of a set of leaves that may be divided further.
pub(super) fn divisible(cells: &BTreeSet<Cell>, deepest: u8) -> HashSet<Cell> {
    cells.iter().filter(|cell| cell.level < deepest).copied().collect()
}
