//! Seed meshes of surfaces with a planted topology.

use std::collections::{HashMap, HashSet};

use super::test_fields::*;
use super::*;
use crate::field::Field;
use crate::geom::{Aabb, Interval, Jet, Point3, Vec3};

fn seed(field: &dyn Field, bounds: &Aabb) -> Seed {
    seed_mesh(field, bounds, None, &SeedOptions::default()).unwrap()
}

fn failure(text: &str, bounds: &Aabb) -> BaseError {
    seed_mesh(&field(text), bounds, None, &SeedOptions::default()).unwrap_err()
}

/// Boundary loops; checks that the mesh is a manifold, with its boundary exactly in the sides of the box.
fn boundary_loops(mesh: &TriangleMesh, bounds: &Aabb) -> usize {
    let sides = |f: &[u32; 3]| [[f[0], f[1]], [f[1], f[2]], [f[2], f[0]]];
    let mut edges = HashSet::new();
    for edge in mesh.faces.iter().flat_map(sides) {
        assert!(edges.insert(edge), "an edge has two faces on one side");
    }
    let open = edges.iter().filter(|[a, b]| !edges.contains(&[*b, *a]));
    let next: HashMap<u32, u32> = open.map(|[a, b]| (*a, *b)).collect();
    for (a, b) in &next {
        let common = [a, b].map(|v| BoxSides::of(&mesh.positions[*v as usize], bounds));
        assert!(!common[0].common(common[1]).is_empty(), "a boundary edge is not in a side of the box");
    }
    let mut rest: HashSet<u32> = next.keys().copied().collect();
    let mut loops = 0;
    while let Some(start) = rest.iter().next().copied() {
        let mut v = start;
        while rest.remove(&v) {
            v = next[&v];
        }
        assert_eq!(v, start);
        loops += 1;
    }
    // Around every vertex there is one fan of faces: no more half edges start at it than the links of one fan have.
    let mut fans: HashMap<u32, HashMap<u32, u32>> = HashMap::new();
    for f in &mesh.faces {
        for k in 0..3 {
            fans.entry(f[k]).or_default().insert(f[(k + 1) % 3], f[(k + 2) % 3]);
        }
    }
    for (v, link) in fans {
        let ends: HashSet<u32> = link.values().copied().collect();
        let start = link.keys().find(|k| !ends.contains(k)).or(link.keys().min()).copied();
        let mut at = start.unwrap();
        let mut count = 0;
        while let Some(after) = link.get(&at) {
            (at, count) = (*after, count + 1);
            if Some(at) == start {
                break;
            }
        }
        assert_eq!(count, link.len(), "vertex {v} has more than one fan");
    }
    loops
}

/// Euler number, components, boundary loops, and whether they are certain.
fn topology(text: &str, bounds: &Aabb) -> (i64, usize, usize, bool) {
    let seed = seed(&field(text), bounds);
    let loops = boundary_loops(&seed.mesh, bounds);
    assert_eq!(seed.mesh.clip.is_some(), loops > 0);
    (seed.mesh.euler_number(), seed.mesh.component_count(), loops, seed.certified)
}

/// The formula with x, y, z replaced by coordinates in a turned frame.
fn turned(text: &str) -> String {
    let axes = nalgebra::Rotation3::from_euler_angles(0.3, 0.7, 1.1);
    let row = |i: usize| format!("(({:e})x+({:e})y+({:e})z)", axes[(i, 0)], axes[(i, 1)], axes[(i, 2)]);
    text.chars()
        .map(|c| match c {
            'x' => row(0),
            'y' => row(1),
            'z' => row(2),
            other => other.to_string(),
        })
        .collect()
}

#[test]
fn closed_surfaces_have_their_topology_for_certain() {
    for Example { name, field, bounds, euler, .. } in paper_surfaces() {
        let seed = seed(&field, &bounds);
        let found = (seed.mesh.euler_number(), seed.mesh.component_count(), seed.certified);
        assert_eq!(found, (euler, 1, true), "{name}");
        assert_eq!(boundary_loops(&seed.mesh, &bounds), 0, "{name}");
        assert!(!seed.negative_outside);
    }
    for (text, half, euler, parts) in [
        // Three nested spheres, eight blobs, a thin torus, and a surface of genus 5 (Schwarz's P in a cube of blobs).
        ("(x^2+y^2+z^2-1)(x^2+y^2+z^2-1.5)(x^2+y^2+z^2-2)", 1.6, 6, 3),
        ("x^4+y^4+z^4-1.5(x^2+y^2+z^2)+1.2", 2.0, 16, 8),
        ("(x^2+y^2+z^2+1-0.0025)^2-4(x^2+y^2)", 1.2, 0, 1),
        ("x^4-5x^2+y^4-5y^2+z^4-5z^2+11.8", 3.0, -8, 1),
    ] {
        assert_eq!(topology(text, &cube(half)), (euler, parts, 0, true), "{text}");
        assert_eq!(topology(&turned(text), &cube(1.8 * half)), (euler, parts, 0, true), "turned {text}");
    }
}

#[test]
fn thin_and_small_parts_are_found() {
    let thin = "(sqrt(x^2+y^2)-1)^2+z^2-0.0001";
    assert_eq!(topology(thin, &find_box(&field(thin)).unwrap()), (0, 1, 0, true));
    let tilted = turned(thin);
    assert_eq!(topology(&tilted, &find_box(&field(&tilted)).unwrap()), (0, 1, 0, true));
    for center in [Vec3::zeros(), Vec3::new(0.613, -0.347, 0.777)] {
        let small = seed(&sphere_at(center, 1e-3), &cube(1.0));
        assert_eq!((small.mesh.euler_number(), small.certified), (2, true));
    }
    // Far apart, so that one box around both hides them from any reasonable grid.
    let two = "((x-0.9)^2+(y-0.8)^2+(z+0.7)^2-1e-6)((x+0.9)^2+(y+0.8)^2+(z-0.7)^2-1e-6)";
    assert_eq!(topology(two, &cube(1.0)), (4, 2, 0, true));
}

#[test]
fn a_plate_with_twenty_holes_has_genus_20() {
    let plate = "z^2-0.15+0.5*cos(pi*x/2)^4*sin(pi*y/2)^4+(x/5.6)^20+(y/4.6)^20";
    assert_eq!(topology(plate, &find_box(&field(plate)).unwrap()), (-38, 1, 0, true));
}

/// Its box was a million wide: far out, the search took what bounds could not exclude along the axes for stable.
#[test]
fn the_box_of_a_turned_product_is_narrow() {
    let turned = field(&turned("(x^2+1)(y^2+1)(z^2+1)+8xyz-2"));
    let found = find_box(&turned).unwrap();
    assert!(found.size().max() < 20.0, "{found:?}");
}

#[test]
fn surfaces_cut_by_the_box_end_in_its_sides() {
    let gyroid = "sin(x)cos(y)+sin(y)cos(z)+sin(z)cos(x)";
    let (euler, parts, loops, certified) = topology(gyroid, &cube(0.9 * std::f64::consts::PI));
    assert_eq!((euler, parts, loops, certified), (-3, 1, 1, true));
    // Schwarz's P in a cell: a sphere with six holes.
    assert_eq!(topology("cos(x)+cos(y)+cos(z)", &cube(3.2)), (-4, 1, 6, true));
    assert_eq!(topology(PLANE, &cube(1.0)), (1, 1, 1, true));
    assert_eq!(topology(CYLINDER, &cube(2.0)), (0, 1, 2, true));
    assert_eq!(topology("sin(z)-sinh(x)sinh(y)", &cube(3.0)).2, 1);
    let cap = Aabb::new(Vec3::repeat(-2.0), Vec3::new(0.5, 2.0, 2.0));
    assert_eq!(topology("x^2+y^2+z^2-1", &cap), (1, 1, 1, true));
}

#[test]
fn contacts_with_the_sides_are_no_boundary_or_are_named() {
    // The sphere touches all six sides in a point: closed, but no certificate.
    assert_eq!(topology("x^2+y^2+z^2-1", &cube(1.0)), (2, 1, 0, false));
    let unit = Aabb::new(Vec3::zeros(), Vec3::repeat(1.0));
    let side = BoxSide { axis: 2, upper: false };
    assert_eq!(failure("z", &unit), BaseError::SurfaceInSide { side });
    assert_eq!(failure("-z", &unit), BaseError::SurfaceInSide { side });
    // Through corners and edges of the box.
    assert_eq!(topology("x+y-2z", &unit).0, 1);
    assert_eq!(topology("x-y", &unit).0, 1);
}

#[test]
fn singular_surfaces_are_named_also_where_the_box_cuts_them() {
    let at = |text: &str, half: f64| match failure(text, &cube(half)) {
        BaseError::Singular { at } => at,
        other => panic!("{text}: {other}"),
    };
    assert!(at("x^2+y^2-z^2", 1.0).norm() < 1e-6);
    assert!(at("x^2-y^2z", 1.0).xy().norm() < 1e-6);
    assert!(at("(x^2+y^2+z^2)^2-4(x^2+y^2)", 2.5).norm() < 1e-3);
    assert!(at("4(x^2+y^2+z^2)+16xyz-1", 1.0).map(f64::abs).add_scalar(-0.5).norm() < 1e-6);
}

#[test]
fn a_kink_has_no_certificate() {
    let (euler, parts, _, certified) = topology("abs(x)+abs(y)+abs(z)-1", &cube(2.0));
    assert_eq!((euler, parts, certified), (2, 1, false));
}

/// A field whose bounds of the gradient are those of its negative.
struct Liar(crate::field::Formula);

impl Field for Liar {
    fn value(&self, p: Point3) -> f64 {
        self.0.value(p)
    }
    fn gradient(&self, p: Point3) -> (f64, Vec3) {
        self.0.gradient(p)
    }
    fn jet(&self, p: Point3) -> Jet {
        self.0.jet(p)
    }
    fn range(&self, cell: &Aabb) -> Interval {
        self.0.range(cell)
    }
    fn gradient_range(&self, cell: &Aabb) -> (Interval, [Interval; 3]) {
        let (f, gradient) = self.0.gradient_range(cell);
        (f, gradient.map(|g| -g))
    }
    fn rounding_bound(&self, p: Point3) -> f64 {
        self.0.rounding_bound(p)
    }
}

#[test]
fn nothing_is_certain_with_a_gradient_that_contradicts_the_values() {
    let options = SeedOptions { most_cells: 4000, ..SeedOptions::default() };
    match seed_mesh(&Liar(unit_sphere()), &cube(1.3), None, &options) {
        Ok(seed) => assert!(!seed.certified),
        Err(error) => assert!(
            matches!(error, BaseError::UnresolvedCells { .. } | BaseError::Unresolved { .. }),
            "{error}"
        ),
    }
}

#[test]
fn a_mesh_from_too_few_cells_is_not_certain() {
    let Example { field, bounds, .. } = &paper_surfaces()[5];
    let options = SeedOptions { most_cells: 500, ..SeedOptions::default() };
    match seed_mesh(field, bounds, None, &options) {
        Ok(seed) => assert!(!seed.certified),
        Err(error) => assert!(
            matches!(error, BaseError::UnresolvedCells { .. } | BaseError::Unresolved { .. }),
            "{error}"
        ),
    }
}

#[test]
fn the_seed_does_not_depend_on_the_number_of_threads() {
    let on = |threads: usize| {
        let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap();
        pool.install(|| seed(&field(CHAIR), &cube(8.0)).mesh)
    };
    assert_eq!(on(1), on(3));
}
