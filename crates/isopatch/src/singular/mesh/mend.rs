//! Where triangles turn over: vertices move on the surface, then edges are divided.

use super::decimate::Limits;
use super::flip::flip;
use super::quality::Judge;
use super::singular_mesh::{EdgeTag, SingularMesh, VertexKind};
use crate::base::BoxSides;
use crate::field::Field;
use crate::geom::{Point3, Vec3};

/// Rounds over all triangles that turn over.
const ROUNDS: usize = 12;
/// Newton steps onto the surface.
const STEPS: usize = 30;
/// Shares of the way to a neighbour, or to the middle of all, that are tried.
const SHARES: [f64; 4] = [0.25, 0.5, 0.75, 1.0];
/// A move has to raise the least cosine around the vertex by this much.
const WORTH: f64 = 0.02;

/// Times that edges are divided.
const DIVISIONS: usize = 4;

/// Moves vertices, flips and divides edges, until no triangle turns over or nothing helps.
pub(super) fn mend(field: &dyn Field, mesh: &mut SingularMesh, limits: Limits) {
    move_vertices(field, mesh, limits);
    flip(field, mesh, limits);
    for _ in 0..DIVISIONS {
        move_vertices(field, mesh, limits);
        if !divide(field, mesh) {
            return;
        }
        flip(field, mesh, limits);
    }
    move_vertices(field, mesh, limits);
}

/// The triangles that turn over.
pub(super) fn turned(field: &dyn Field, mesh: &SingularMesh) -> Vec<[u32; 3]> {
    mesh.triangles.iter().filter(|t| cosine(field, mesh, **t) <= 0.0).copied().collect()
}

/// Moves regular vertices of triangles that turn over, where that helps.
fn move_vertices(field: &dyn Field, mesh: &mut SingularMesh, limits: Limits) {
    for _ in 0..ROUNDS {
        let mut moved = false;
        for v in turned(field, mesh).into_iter().flatten() {
            moved |= improve(field, mesh, v, limits);
        }
        if !moved {
            return;
        }
    }
}

/// Divides the longest smooth edge of every triangle that turns over; was there any?
fn divide(field: &dyn Field, mesh: &mut SingularMesh) -> bool {
    let mut divided = false;
    for t in turned(field, mesh) {
        if !mesh.triangles.contains(&t) {
            continue;
        }
        let edges = mesh.edges();
        let ends = (0..3).map(|k| (t[k].min(t[(k + 1) % 3]), t[k].max(t[(k + 1) % 3]))).map(|(a, b)| [a, b]);
        let smooth = ends.filter(|e| edges[e].len() == 2 && mesh.tag(*e, 2) == EdgeTag::Smooth);
        let length =
            |e: &[u32; 2]| (mesh.positions[e[0] as usize] - mesh.positions[e[1] as usize]).norm_squared();
        let Some(longest) = smooth.max_by(|x, y| length(x).total_cmp(&length(y))) else { continue };
        divided |= divide_edge(field, mesh, longest);
    }
    divided
}

/// Divides a smooth edge, by its ends with the smaller number first, at a point of the surface near its middle; is there one?
pub(super) fn divide_edge(field: &dyn Field, mesh: &mut SingularMesh, [a, b]: [u32; 2]) -> bool {
    let around: Vec<usize> = (0..mesh.triangles.len())
        .filter(|t| mesh.triangles[*t].contains(&a) && mesh.triangles[*t].contains(&b))
        .collect();
    if around.len() != 2 || mesh.tag([a, b], 2) != EdgeTag::Smooth {
        return false;
    }
    let [p, q] = [a, b].map(|v| mesh.positions[v as usize]);
    let middle = 0.5 * (p + q);
    let near = onto_surface(field, middle).filter(|at| (at - middle).norm_squared() < (p - q).norm_squared());
    let Some(at) = near else { return false };
    let m = mesh.positions.len() as u32;
    mesh.positions.push(at);
    mesh.vertices.push(VertexKind::Regular);
    mesh.sides.push(BoxSides::NONE);
    for t in around {
        let old = mesh.triangles[t];
        mesh.triangles[t] = old.map(|v| if v == a { m } else { v });
        mesh.triangles.push(old.map(|v| if v == b { m } else { v }));
    }
    true
}

/// Puts a vertex where the triangles around it are best; did that help?
fn improve(field: &dyn Field, mesh: &mut SingularMesh, v: u32, limits: Limits) -> bool {
    let i = v as usize;
    if mesh.vertices[i] != VertexKind::Regular || !mesh.sides[i].is_empty() {
        return false;
    }
    let star: Vec<[u32; 3]> = mesh.triangles.iter().filter(|t| t.contains(&v)).copied().collect();
    let mut around: Vec<u32> = star.iter().flatten().copied().filter(|w| *w != v).collect();
    around.sort_unstable();
    around.dedup();
    let here = mesh.positions[i];
    let worst = |mesh: &SingularMesh| star.iter().map(|t| cosine(field, mesh, *t)).fold(1.0, f64::min);
    let is_near = |mesh: &SingularMesh| {
        // Only these triangles are looked at: their corners under new numbers.
        star.iter().all(|t| {
            let positions = t.map(|w| mesh.positions[w as usize]);
            Judge::new(field, &positions, &[VertexKind::Regular; 3], limits).is_near([0, 1, 2])
        })
    };
    let middle = around.iter().map(|w| mesh.positions[*w as usize]).sum::<Point3>() / around.len() as f64;
    let goals = around.iter().map(|w| mesh.positions[*w as usize]).chain([middle]);
    let tries: Vec<Point3> = goals
        .flat_map(|goal| SHARES.map(|share| here + (goal - here) * share))
        .filter_map(|p| onto_surface(field, p))
        .collect();
    let mut best = (worst(mesh) + WORTH, here);
    for p in tries {
        mesh.positions[i] = p;
        let found = worst(mesh);
        if found > best.0 && is_near(mesh) {
            best = (found, p);
        }
    }
    mesh.positions[i] = best.1;
    best.1 != here
}

/// The least cosine of an angle between a triangle and the surface at its regular corners.
fn cosine(field: &dyn Field, mesh: &SingularMesh, corners: [u32; 3]) -> f64 {
    let [p, q, r] = corners.map(|v| mesh.positions[v as usize]);
    let Some(normal) = (q - p).cross(&(r - p)).try_normalize(0.0) else { return -1.0 };
    let regular = corners.into_iter().filter(|v| mesh.vertices[*v as usize] == VertexKind::Regular);
    let cosines = regular.map(|v| {
        let gradient: Vec3 = field.gradient(mesh.positions[v as usize]).1;
        gradient.dot(&normal) / gradient.norm()
    });
    cosines.fold(1.0, f64::min)
}

fn onto_surface(field: &dyn Field, start: Point3) -> Option<Point3> {
    let mut p = start;
    for _ in 0..STEPS {
        let (f, gradient) = field.gradient(p);
        let step = gradient * (f / gradient.norm_squared());
        if !step.iter().all(|c| c.is_finite()) {
            return None;
        }
        p -= step;
        if step.norm() <= 4.0 * f64::EPSILON * p.norm() {
            return Some(p);
        }
    }
    None
}
