//! Surfaces over polygons through the machinery for all surfaces: tessellation, queries, a resolution for a tolerance.
#![allow(clippy::unwrap_used, reason = "a test that fails by a panic is a test that fails")]

mod support;

use isopatch::geom::{Point3, Vec3};
use isopatch::hull::Side;
use isopatch::hybrid::{FaceCells, HermitePolygons, HybridFunction, HybridSurface};
use isopatch::mesh::HalfEdgeMesh;
use isopatch::query::{QueryOptions, Ray, SurfaceQuery};
use isopatch::surface::{PatchId, Surface};
use isopatch::tessellate::{APatchResolution, HybridTessellation, resolution_for, tessellate_hybrid};
use std::collections::HashMap;
use support::meshes::noise3;
use support::polyhedra::{self, Ellipsoid, Polyhedron};

const SPHERE: Ellipsoid = Ellipsoid(Vec3::new(1.0, 1.0, 1.0));

fn sphere(body: Polyhedron) -> HybridSurface {
    sphere_of(body, polyhedra::sectors)
}

fn sphere_of(body: Polyhedron, choice: polyhedra::Choice) -> HybridSurface {
    let body = SPHERE.project(body);
    let gradients: Vec<Vec3> = body.0.iter().map(|p| 2.0 * p).collect();
    let data = polyhedra::polygons(&body, &gradients);
    HybridSurface::new(HybridFunction::new(polyhedra::hull(data, choice, |_| SPHERE.quadric())))
}

/// Edges that are in one face only; every edge is used once in each direction.
fn border<const N: usize>(faces: &[[u32; N]]) -> usize {
    let mut uses: HashMap<(u32, u32), usize> = HashMap::new();
    for face in faces {
        for k in 0..N {
            let edge = (face[k], face[(k + 1) % N]);
            if edge.0 != edge.1 {
                *uses.entry(edge).or_default() += 1;
            }
        }
    }
    assert!(uses.values().all(|n| *n == 1));
    uses.keys().filter(|(a, b)| !uses.contains_key(&(*b, *a))).count()
}

fn tessellated(surface: &HybridSurface, along: usize, across: usize) -> HybridTessellation {
    tessellate_hybrid(surface, APatchResolution { along, across }).unwrap()
}

#[test]
fn tessellations_have_no_cracks_and_quadrilaterals_where_they_can() {
    for body in [polyhedra::rhombicuboctahedron(), polyhedra::icosidodecahedron(), polyhedra::prism(7)] {
        let surface = HybridSurface::new(polyhedra::random(body, polyhedra::sectors, [0.02, 0.1], 1));
        let function = surface.function();
        let pyramids = function.faces().iter().filter(|f| matches!(f, FaceCells::Pyramid(_))).count();
        for (n, m) in [(1, 1), (2, 1), (3, 2), (8, 3)] {
            let found = tessellated(&surface, n, m);
            let mesh = &found.mesh;
            assert_eq!(border(&mesh.triangles), 0, "{n} {m}");
            let edges = 3 * mesh.triangles.len() / 2;
            assert_eq!(mesh.positions.len() as i64 - edges as i64 + mesh.triangles.len() as i64, 2);
            assert_eq!(mesh.patches.len(), mesh.triangles.len());
            // Lenses end in triangles on both sides.
            let lenses = surface.square_edges().len() * m * n.saturating_sub(2);
            assert_eq!(found.quads.len(), pyramids * n * n + lenses);
            let mut mixed: Vec<[u32; 4]> = found.triangles.iter().map(|[a, b, c]| [*a, *b, *c, *c]).collect();
            mixed.extend(&found.quads);
            assert_eq!(border(&mixed), 0);
            for (triangle, patch) in mesh.triangles.iter().zip(&mesh.patches) {
                let bounds = surface.bounds(*patch);
                assert!(triangle.iter().all(|v| bounds.grown(1e-9).contains(&mesh.positions[*v as usize])));
            }
        }
    }
}

#[test]
fn every_point_is_on_the_sphere_with_its_normal() {
    for body in [polyhedra::cube(), polyhedra::dodecahedron(), polyhedra::icosidodecahedron()] {
        let mesh = tessellated(&sphere(body), 6, 2).mesh;
        for (p, n) in mesh.positions.iter().zip(&mesh.normals) {
            assert!((p.norm() - 1.0).abs() < 1e-13 && (n - p).norm() < 1e-12);
        }
        for t in &mesh.triangles {
            let [a, b, c] = t.map(|v| mesh.positions[v as usize]);
            assert!((b - a).cross(&(c - a)).dot(&(a + b + c)) > 0.0);
        }
    }
}

#[test]
fn tolerances_hold() {
    let surface = sphere(polyhedra::icosidodecahedron());
    let found = resolution_for(&surface, 2.0, 1e-3);
    let mesh = tessellate_hybrid(&surface, found.resolution).unwrap().mesh;
    let depth =
        |t: &[u32; 3]| 1.0 - (t.iter().map(|v| mesh.positions[*v as usize]).sum::<Point3>() / 3.0).norm();
    let worst = mesh.triangles.iter().map(depth).fold(0.0, f64::max);
    assert!(found.error <= 1e-3 && worst < 4.0 / 3.0 * 2e-3 && worst > 1e-4, "{worst:e} {found:?}");
}

#[test]
fn nearest_points_and_rays_are_found_on_polygons() {
    for body in [polyhedra::cube(), polyhedra::dodecahedron(), polyhedra::prism(7)] {
        let surface = sphere(body);
        let query = SurfaceQuery::new(&surface, &QueryOptions::default());
        for n in 0..20 {
            let p = 1.8 * noise3(n) + Vec3::repeat(0.01);
            let nearest = query.nearest(&p).unwrap();
            assert!(((nearest.point - p).norm() - (p.norm() - 1.0).abs()).abs() < 1e-10, "{p:?}");
            assert_eq!(query.is_inside(&p), Some(p.norm() < 1.0));
            let ray = Ray { origin: 3.0 * p.normalize(), direction: -p };
            let hits = query.hits(&ray);
            assert_eq!(hits.len(), 2, "{p:?}");
            let found = hits[0].point;
            assert!((found - p.normalize()).norm() < 1e-10);
        }
    }
}

/// Two halves of a cube's surface with a crease between, straight where its data are.
#[test]
fn creases_part_the_normals_and_nothing_else() {
    let (vertices, faces) = polyhedra::cube();
    let mesh = HalfEdgeMesh::from_faces(vertices.len(), &faces).unwrap();
    let normal = |f: usize| {
        let [a, b, c] = [0, 1, 2].map(|k| vertices[faces[f][k] as usize]);
        (b - a).cross(&(c - b)).normalize()
    };
    let gradients = mesh.half_edges().map(|h| normal(mesh.face(h).index())).collect();
    let sharp = vec![true; mesh.edge_count()];
    let data = HermitePolygons::with_creases(mesh, vertices.clone(), gradients, sharp).unwrap();
    let surface = HybridSurface::new(HybridFunction::new(polyhedra::hull(data, polyhedra::sectors, |_| {
        SPHERE.quadric()
    })));
    assert_eq!((surface.flat_count(), surface.square_edges().len()), (6, 0));
    let mesh = tessellated(&surface, 4, 2).mesh;
    assert_eq!(border(&mesh.triangles), 0);
    for ((triangle, corners), patch) in mesh.triangles.iter().zip(&mesh.corner_normals).zip(&mesh.patches) {
        let wanted = normal(patch.index());
        assert!(corners.iter().all(|n| (mesh.normals[*n as usize] - wanted).norm() < 1e-14));
        let [a, b, c] = triangle.map(|v| mesh.positions[v as usize]);
        assert!((b - a).cross(&(c - a)).dot(&wanted) > 0.0);
    }
}

/// Shape control: a larger value at an apex pulls the surface down, and moves no vertex.
#[test]
fn values_at_apexes_control_the_shape() {
    let surface = sphere(polyhedra::icosidodecahedron());
    let f = surface.function().hull().data.mesh().faces().next().unwrap();
    let before = surface.sample(PatchId(f.0), [0.3, 0.3]);
    let jet = surface.function().hull().faces[f.index()].jet(Side::Outer).unwrap();
    let higher = isopatch::hybrid::Jet { value: jet.value + 0.3, ..jet };
    let vertices = surface.function().hull().data.positions().to_vec();
    let moved = HybridSurface::new(surface.into_function().with_jets(&[(f, Side::Outer, higher)]));
    let after = moved.sample(PatchId(f.0), [0.3, 0.3]);
    assert!((after.point - before.point).dot(&before.normal) < -1e-4);
    assert_eq!(moved.function().hull().data.positions(), vertices);
}

/// Points in lanes are those of single rays.
#[test]
fn tables_agree_with_single_rays() {
    use isopatch::apatch::grid::GridOut;
    use isopatch::geom::Points;
    use isopatch::hybrid::Foot;
    use isopatch::hybrid::grid::{PyramidTable, SectorTable};
    let part = |i: i32| f64::from(i) / 7.0;
    let square: Vec<[f64; 2]> = (0..64).map(|i| [part(i % 8), part(i / 8)]).collect();
    let sector: Vec<[f64; 3]> =
        square.iter().map(|[a, b]| [*a, (1.0 - a) * b, (1.0 - a) * (1.0 - b)]).collect();
    let (pyramids, sectors) = (PyramidTable::new(&square), SectorTable::new(&sector));
    let mut kinds = [0; 2];
    for body in [polyhedra::rhombicuboctahedron(), polyhedra::icosidodecahedron()] {
        let f = polyhedra::random(body, polyhedra::mixed, [0.03, 0.15], 3);
        for face in f.hull().data.mesh().faces() {
            let (mut points, mut normals) = (Points::zeros(64), Points::zeros(64));
            let mut out = GridOut { points: points.view_mut(), normals: Some(normals.view_mut()) };
            let foot = |i: usize| match &f.faces()[face.index()] {
                FaceCells::Pyramid(_) => Foot::Pyramid(square[i]),
                _ => Foot::Sector(1, sector[i]),
            };
            match &f.faces()[face.index()] {
                FaceCells::Pyramid(_) => pyramids.evaluate(&f, face, &mut out),
                FaceCells::Sectors(_) => sectors.evaluate(&f, face, 1, &mut out),
                _ => continue,
            }
            kinds[usize::from(matches!(f.faces()[face.index()], FaceCells::Pyramid(_)))] += 1;
            for i in 0..64 {
                match f.shoot_from(face, foot(i), [[0.0; 3]; 2]) {
                    Some(shot) => {
                        assert!((points.get(i) - shot.point).norm() < 1e-13, "{face:?} {i}");
                        let wanted = shot.gradient.normalize();
                        assert!((normals.get(i) - wanted).norm() < 1e-11, "{face:?} {i}");
                    }
                    None => assert!(points.get(i).x.is_nan()),
                }
            }
        }
    }
    assert!(kinds[0] > 5 && kinds[1] > 5, "{kinds:?}");
}

/// Triangles have one table, whatever their cells are.
#[test]
fn tables_of_triangles_agree_with_single_rays() {
    use isopatch::apatch::grid::GridOut;
    use isopatch::bernstein::triangle;
    use isopatch::geom::Points;
    use isopatch::hybrid::grid::TriangleTable;
    let lattice = triangle::lattice(9);
    let table = TriangleTable::new(&lattice);
    let (mut in_sectors, mut compared) = (0, 0);
    let all = [
        polyhedra::random(polyhedra::icosidodecahedron(), polyhedra::sectors, [0.03, 0.15], 3),
        sphere_of(polyhedra::icosidodecahedron(), polyhedra::fans).into_function(),
    ];
    let faces = all.iter().flat_map(|f| f.hull().data.mesh().faces().map(move |face| (f, face)));
    for (f, face) in faces.filter(|(f, face)| f.corners(*face).len() == 3) {
        in_sectors += usize::from(matches!(f.faces()[face.index()], FaceCells::Sectors(_)));
        let (mut points, mut normals) = (Points::zeros(table.len()), Points::zeros(table.len()));
        let mut out = GridOut { points: points.view_mut(), normals: Some(normals.view_mut()) };
        table.evaluate(f, face, &mut out);
        for (i, x) in lattice.iter().enumerate() {
            let Some(shot) = f.shoot_face(face, [x[0], x[1]]) else {
                assert!(points.get(i).x.is_nan());
                continue;
            };
            compared += 1;
            assert!((points.get(i) - shot.point).norm() < 1e-12, "{face:?} {i}");
            assert!((normals.get(i) - shot.gradient.normalize()).norm() < 1e-11, "{face:?} {i}");
        }
    }
    assert!(in_sectors == 20 && compared > 2000, "{in_sectors} {compared}");
}
