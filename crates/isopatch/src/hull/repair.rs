//! Normals that see their faces, and other directions and normals for faces whose apexes do not fit.

use super::builder::Builder;
use super::face::FaceFrame;
use super::hermite::HermiteMesh;
use super::options::RobustApexes;
use super::relax;
use super::visibility::most_visible_direction;
use crate::geom::Vec3;
use crate::mesh::{EdgeId, FaceId, HalfEdgeId, VertexId, normals};

/// Directions closer to the plane of a face than this (as the sine of the angle) are not tried for its apexes.
const TRIED_FACING: f64 = 0.15;

/// Mean of the unit gradients at the corners.
pub(super) fn mean_normal(frame: &FaceFrame) -> Vec3 {
    frame.n.iter().map(Vec3::normalize).sum()
}

/// `v` as a unit vector, or the normal of the face if it faces that with a product of `least` or less.
pub(super) fn facing(v: Vec3, frame: &FaceFrame, least: f64) -> Vec3 {
    v.try_normalize(0.0).filter(|d| d.dot(&frame.normal) > least).unwrap_or(frame.normal)
}

/// The smallest product of the unit gradients at a vertex with the unit normals of their faces.
pub(super) fn visibility(
    data: &HermiteMesh,
    v: VertexId,
    gradient: impl Fn(HalfEdgeId) -> Vec3,
) -> Option<f64> {
    let mesh = data.mesh();
    let product = |h| normals::of_face(mesh, data.positions(), mesh.face(h)).dot(&gradient(h).normalize());
    mesh.ring(v).map(product).min_by(f64::total_cmp)
}

/// Turns every gradient that sees a face around its vertex under less than `least` into the most visible direction.
pub(super) fn turn_hidden_normals(data: &mut HermiteMesh, least: f64) {
    let hidden: Vec<VertexId> = data
        .mesh()
        .vertices()
        .filter(|v| visibility(data, *v, |h| data.gradient(h)).is_some_and(|seen| seen < least))
        .collect();
    let sectors: Vec<Vec<HalfEdgeId>> = hidden.into_iter().flat_map(|v| data.sectors(v)).collect();
    for sector in sectors {
        let seen = |h: &HalfEdgeId| normal_at(data, *h).dot(&data.gradient(*h).normalize());
        if sector.iter().all(|h| seen(h) >= least) {
            continue;
        }
        if let Some((direction, _)) = most_visible(data, &sector) {
            for h in sector {
                data.set_gradient(h, data.gradient(h).norm() * direction);
            }
        }
    }
}

/// The same for vertices at fault and around it, beside a finished hull.
pub(super) fn show_hidden_normals(builder: &mut Builder<'_>, vertices: &[VertexId]) {
    let mesh = builder.data.mesh();
    let mut near: Vec<VertexId> =
        vertices.iter().flat_map(|v| mesh.ring(*v)).flat_map(|h| mesh.triangle(mesh.face(h))).collect();
    near.sort_unstable();
    near.dedup();
    let mut touched = Vec::new();
    for sector in near.into_iter().flat_map(|v| builder.data.sectors(v)).collect::<Vec<_>>() {
        let seen = |h: &HalfEdgeId| normal_at(&builder.data, *h).dot(&builder.data.gradient(*h).normalize());
        let least = sector.iter().map(seen).fold(f64::INFINITY, f64::min);
        if let Some((direction, _)) =
            most_visible(&builder.data, &sector).filter(|(_, best)| least < 0.5 * best)
        {
            for h in sector {
                builder.turn(h, builder.data.gradient(h).norm() * direction);
                touched.push(builder.data.mesh().face(h));
            }
        }
    }
    touched.sort_unstable();
    touched.dedup();
    builder.recheck(&touched);
}

/// Unit normal of the face at a corner.
pub(super) fn normal_at(data: &HermiteMesh, corner: HalfEdgeId) -> Vec3 {
    normals::of_face(data.mesh(), data.positions(), data.mesh().face(corner))
}

/// The direction that sees the faces at these corners best, and the least product with their normals.
pub(super) fn most_visible(data: &HermiteMesh, corners: &[HalfEdgeId]) -> Option<(Vec3, f64)> {
    let around: Vec<Vec3> = corners.iter().map(|h| normal_at(data, *h)).collect();
    most_visible_direction(&around)
}

/// Tries other directions for bad faces, together with the bad faces beside them and alone, then other normals at their
/// vertices; what makes fewer faces bad is kept.
pub(super) fn repair(builder: &mut Builder<'_>, rule: &RobustApexes) {
    for _ in 0..rule.repairs {
        let bad: Vec<FaceId> = builder.data.mesh().faces().filter(|f| builder.is_bad(*f)).collect();
        let mut better = false;
        for cluster in clusters(builder, &bad) {
            better |= redirect(builder, &cluster, rule);
            if cluster.len() > 1 {
                for f in &cluster {
                    better |= redirect(builder, &[*f], rule);
                }
            }
            better |= turn_normals(builder, &cluster, rule);
        }
        for e in builder.bad_edges() {
            better |= lean(builder, e, rule);
        }
        if !better {
            break;
        }
    }
    relax_all(builder, rule);
}

/// Relaxes around what is bad.
fn relax_all(builder: &mut Builder<'_>, rule: &RobustApexes) {
    let bad: Vec<FaceId> = builder.data.mesh().faces().filter(|f| builder.is_bad(*f)).collect();
    for cluster in clusters(builder, &bad) {
        relax::relax(builder, &cluster, rule);
    }
}

/// Relaxes around a vertex, if something is bad there.
pub(super) fn relax_around(builder: &mut Builder<'_>, v: VertexId, rule: &RobustApexes) {
    let mesh = builder.data.mesh();
    let mut bad: Vec<FaceId> = mesh
        .ring(v)
        .flat_map(|h| mesh.triangle(mesh.face(h)))
        .flat_map(|v| mesh.ring(v))
        .map(|h| mesh.face(h))
        .filter(|f| builder.is_bad(*f))
        .collect();
    bad.sort_unstable();
    bad.dedup();
    for cluster in clusters(builder, &bad) {
        relax::relax_here(builder, &cluster, rule);
    }
}

/// Gives the sides of creases one normal where they meet at a vertex at fault, if one sees all faces there: a crease that turns back
/// sharply may have a tangent plane in its tip.
pub(super) fn join_sides(builder: &mut Builder<'_>, rule: &RobustApexes) {
    for e in builder.bad_edges() {
        let Some(v) = builder.fault_of_crease(e) else { continue };
        let ring: Vec<HalfEdgeId> = builder.data.mesh().ring(v).collect();
        let seen = most_visible(&builder.data, &ring).filter(|(_, product)| *product > rule.visibility);
        let Some((direction, _)) = seen else { continue };
        let (before, mark) = (builder.score, builder.mark());
        let gradients: Vec<(HalfEdgeId, Vec3)> =
            ring.iter().map(|h| (*h, builder.data.gradient(*h).norm() * direction)).collect();
        let faces: Vec<FaceId> = ring.iter().map(|h| builder.data.mesh().face(*h)).collect();
        builder.set(&[], &gradients);
        builder.place_by_default(&faces, rule);
        relax_around(builder, v, rule);
        if builder.score >= before {
            builder.roll_back_to(mark);
        }
    }
}

/// The least product with the normals of the faces around a vertex of the best direction, in the sector where that is least.
pub(super) fn best_visibility(data: &HermiteMesh, v: VertexId) -> f64 {
    let of = |sector: &Vec<HalfEdgeId>| most_visible(data, sector).map_or(-1.0, |(_, product)| product);
    data.sectors(v).iter().map(of).fold(f64::INFINITY, f64::min)
}

/// Vertices at which something is bad: for each bad face the one whose faces are seen worst, for each bad edge the end where that is
/// worse.
pub(super) fn at_fault(builder: &Builder<'_>) -> Vec<VertexId> {
    let (data, mesh) = (&builder.data, builder.data.mesh());
    let mut found = Vec::new();
    let mut take = |among: &[VertexId]| {
        let seen = among.iter().copied().map(|v| (v, best_visibility(data, v)));
        found.extend(seen.min_by(|a, b| a.1.total_cmp(&b.1)).map(|(v, _)| v));
    };
    for f in mesh.faces().filter(|f| builder.fault_of_face(*f).is_some()) {
        take(&mesh.triangle(f));
    }
    for e in builder.bad_edges() {
        let h = mesh.edge_half_edge(e);
        take(&[mesh.origin(h), mesh.dest(h)]);
    }
    found.sort_unstable();
    found.dedup();
    found
}

/// The bad faces as sets that hang together over edges.
fn clusters(builder: &Builder<'_>, bad: &[FaceId]) -> Vec<Vec<FaceId>> {
    clusters_of(builder, bad)
}

/// Faces, in order, as sets that hang together over smooth edges.
pub(super) fn clusters_of(builder: &Builder<'_>, faces: &[FaceId]) -> Vec<Vec<FaceId>> {
    let mut seen = vec![false; faces.len()];
    let mut found = Vec::new();
    for (n, seed) in faces.iter().enumerate() {
        if std::mem::replace(&mut seen[n], true) {
            continue;
        }
        let mut cluster = vec![*seed];
        let mut next = 0;
        while let Some(f) = cluster.get(next).copied() {
            next += 1;
            for g in neighbours(&builder.data, f) {
                if faces.binary_search(&g).is_ok_and(|n| !std::mem::replace(&mut seen[n], true)) {
                    cluster.push(g);
                }
            }
        }
        found.push(cluster);
    }
    found
}

/// The faces across the smooth edges of a face.
fn neighbours(data: &HermiteMesh, f: FaceId) -> impl Iterator<Item = FaceId> + '_ {
    let mesh = data.mesh();
    let smooth = |h: &HalfEdgeId| !data.is_crease(mesh.edge(*h));
    mesh.face_half_edges(f).filter(smooth).filter_map(|h| mesh.twin(h)).map(|g| mesh.face(g))
}

/// Number of directions that [`candidate`] offers.
const CANDIDATES: usize = 8;

/// A direction for the apexes of a face: mixtures of its vertex normals, its own normal, and those of its neighbours.
fn candidate(builder: &Builder<'_>, f: FaceId, which: usize) -> Vec3 {
    let mesh = builder.data.mesh();
    let frame = builder.frame(f);
    let mean = mean_normal(&frame).try_normalize(0.0).unwrap_or(frame.normal);
    let unit = frame.n.map(|n| n.normalize());
    let around = || {
        let normal = |f| normals::of_face(mesh, builder.data.positions(), f);
        neighbours(&builder.data, f).map(normal).fold(frame.normal, |sum, n| sum + n)
    };
    let direction = match which {
        0 => mean,
        1 => mean + frame.normal,
        2 => frame.normal,
        3 => around(),
        4 => 2.0 * mean - frame.normal,
        // Above all three tangent planes as soon as can be.
        5 => most_visible_direction(&unit).map_or(mean, |(d, _)| d),
        6 => most_visible_direction(&unit).map_or(mean, |(d, _)| d + mean),
        _ => mean + around().try_normalize(0.0).unwrap_or(mean),
    };
    facing(direction, &frame, TRIED_FACING)
}

fn redirect(builder: &mut Builder<'_>, faces: &[FaceId], rule: &RobustApexes) -> bool {
    let mut better = false;
    for which in 0..CANDIDATES {
        if !faces.iter().any(|f| builder.is_bad(*f)) {
            break;
        }
        let directions: Vec<(FaceId, Vec3)> =
            faces.iter().map(|f| (*f, candidate(builder, *f, which))).collect();
        better |= builder.attempt(&[], &directions, rule);
    }
    better
}

/// Slopes by which apexes are leaned away from an edge, or towards it.
const LEANS: [f64; 6] = [0.25, 0.5, 1.0, -0.25, -0.5, -1.0];

/// Leans the apexes on both sides of a bad edge, or on one of them, across the edge.
fn lean(builder: &mut Builder<'_>, e: EdgeId, rule: &RobustApexes) -> bool {
    let mut better = false;
    for which in [[true, true], [true, false], [false, true]] {
        for slope in LEANS {
            let Some(joint) = builder.data.joint(e).filter(|_| builder.is_bad_edge(e)) else { return better };
            let faces = joint.into_iter().zip(which).filter(|(_, wanted)| *wanted);
            let directions: Vec<(FaceId, Vec3)> = faces.map(|(h, _)| leaned(builder, h, slope)).collect();
            better |= builder.attempt(&[], &directions, rule);
        }
    }
    better
}

/// The direction of the face of h, with `slope` times the unit vector in the face away from h added.
fn leaned(builder: &Builder<'_>, h: HalfEdgeId, slope: f64) -> (FaceId, Vec3) {
    let mesh = builder.data.mesh();
    let f = mesh.face(h);
    let frame = builder.frame(f);
    let k = mesh.side(h);
    let edge = (frame.p[(k + 1) % 3] - frame.p[k]).normalize();
    let away = frame.normal.cross(&edge);
    (f, facing(builder.faces[f.index()].direction + slope * away, &frame, TRIED_FACING))
}

/// Tries the angle-weighted, the area-weighted and the most visible normal at each vertex of a cluster.
fn turn_normals(builder: &mut Builder<'_>, cluster: &[FaceId], rule: &RobustApexes) -> bool {
    let mut vertices: Vec<VertexId> = cluster.iter().flat_map(|f| builder.data.mesh().triangle(*f)).collect();
    vertices.sort_unstable();
    vertices.dedup();
    let mut better = false;
    let sectors: Vec<Vec<HalfEdgeId>> = vertices.into_iter().flat_map(|v| builder.data.sectors(v)).collect();
    for sector in sectors {
        for normal in normals_at(&builder.data, &sector) {
            let faces: Vec<FaceId> = sector.iter().map(|h| builder.data.mesh().face(*h)).collect();
            if !faces.iter().any(|f| builder.is_bad(*f)) {
                break;
            }
            let gradients: Vec<(HalfEdgeId, Vec3)> =
                sector.iter().map(|h| (*h, builder.data.gradient(*h).norm() * normal)).collect();
            let directions: Vec<(FaceId, Vec3)> =
                faces.iter().map(|f| (*f, builder.default_direction(*f))).collect();
            better |= builder.attempt(&gradients, &directions, rule);
        }
    }
    better
}

/// Other unit normals for a vertex, as the faces at these corners see it.
fn normals_at(data: &HermiteMesh, corners: &[HalfEdgeId]) -> Vec<Vec3> {
    let mesh = data.mesh();
    let (mut by_angle, mut by_area) = (Vec3::zeros(), Vec3::zeros());
    for h in corners.iter().copied() {
        let at = |v: VertexId| data.positions()[v.index()];
        let (o, a, b) = (at(mesh.origin(h)), at(mesh.dest(h)), at(mesh.origin(mesh.prev(h))));
        let area = (a - o).cross(&(b - o));
        by_area += area;
        by_angle += crate::geom::angle_between(&(a - o), &(b - o)) * area.normalize();
    }
    let sums = [by_angle, by_area].into_iter().filter_map(|sum| sum.try_normalize(0.0));
    sums.chain(most_visible(data, corners).map(|(direction, _)| direction)).collect()
}
