//! Rational Bézier triangles: each becomes four untrimmed rational B-spline faces, see [`crate::rational::pieces`].
//!
//! ```text
//!                0                 Faces are triangles: the side s = 0 of their surfaces is a point. An edge of the surface is two
//!               / \                EDGE_CURVEs, the halves of its wire, polynomial cubics; the borders of the surfaces there are
//!            01 ——— 20             the same curves as rational ones, to rounding. The cut at corner k runs from the midpoint of
//!            / \   / \             edge k to that of edge k + 2, and its control points are those of the surfaces on both sides.
//!          1 ——— 12 ——— 2          Seams with the same curve share its halves: there sheets cross.
//! ```

use super::bodies::Body;
use super::geometry::Facing;
use super::product::{Entities, write_header};
use super::{StepOptions, facings, write_bodies};
use crate::bernstein::curve::split_half;
use crate::geom::{Point3, Vec4};
use crate::io::WriteError;
use crate::io::text::push_real;
use crate::rational::pieces::{Piece, pieces};
use crate::surface::{PatchForm, PatchId, Surface};
use crate::tessellate::SharedLattice;
use std::io::Write;

/// Are all patches rational Bézier triangles?
pub fn is_rational(surface: &dyn Surface) -> bool {
    surface.patches().all(|p| matches!(surface.form(p), PatchForm::RationalTriangle { .. }))
}

/// Degree of the wires.
const WIRE: usize = 3;

/// Entities of half a wire.
#[derive(Clone, Copy, Default)]
struct Halves {
    /// The vertex where the wire starts.
    start: u32,
    middle_point: u64,
    middle_vertex: u64,
    edges: [u64; 2],
}

/// Writes a surface of rational triangles.
pub fn write(
    surface: &dyn Surface,
    bodies: &[Body],
    options: &StepOptions,
    out: &mut impl Write,
) -> Result<(), WriteError> {
    check(surface)?;
    let lattice = SharedLattice::new(surface, 2)?;
    write_header(out, options)?;
    let mut entities = Entities { next: 1, out };
    let corners = write_corners(surface, &lattice, &mut entities)?;
    let curves = write_wires(surface, &corners, &mut entities)?;
    let facings = facings(surface, bodies);
    let mut faces = Vec::with_capacity(surface.patch_count());
    for patch in surface.patches() {
        let sides = lattice.edges(patch).map(|side| curves[surface.curve(side.seam as usize) as usize]);
        faces.push(write_patch(surface, patch, &corners, &sides, facings[patch.index()], &mut entities)?);
    }
    let of_patches = |patches: &[PatchId]| {
        let ids = patches.iter().flat_map(|p| faces[p.index()]).map(|id| format!("#{id}"));
        format!("({})", ids.collect::<Vec<_>>().join(","))
    };
    write_bodies(bodies, &of_patches, options, &mut entities)?;
    entities.out.write_all(b"ENDSEC;\nEND-ISO-10303-21;\n")?;
    Ok(())
}

fn check(surface: &dyn Surface) -> Result<(), WriteError> {
    for patch in surface.patches() {
        if let PatchForm::RationalTriangle { weighted, .. } = surface.form(patch)
            && !weighted.iter().all(|p| p.iter().all(|c| c.is_finite()))
        {
            return Err(WriteError::NotFinite { what: "patch", index: patch.index() });
        }
    }
    Ok(())
}

/// Numbers of the point and the vertex of each corner.
fn write_corners<W: Write>(
    surface: &dyn Surface,
    lattice: &SharedLattice,
    entities: &mut Entities<'_, W>,
) -> std::io::Result<Vec<[u64; 2]>> {
    let mut points = vec![Point3::zeros(); lattice.corner_count()];
    for patch in surface.patches() {
        for (k, c) in surface.corners(patch).into_iter().enumerate() {
            points[c as usize] = surface.sample(patch, CORNERS[k]).point;
        }
    }
    points
        .iter()
        .map(|p| {
            let point = write_point(p, entities)?;
            Ok([point, entities.add(&format!("VERTEX_POINT('',#{point})"))?])
        })
        .collect()
}

/// Parameters of the corners.
const CORNERS: [[f64; 2]; 3] = [[1.0, 0.0], [0.0, 1.0], [0.0, 0.0]];

/// The halves of every curve, by its number.
fn write_wires<W: Write>(
    surface: &dyn Surface,
    corners: &[[u64; 2]],
    entities: &mut Entities<'_, W>,
) -> std::io::Result<Vec<Halves>> {
    let seams = surface.seams();
    let count = (0..seams.len()).map(|s| surface.curve(s) as usize + 1).max().unwrap_or(0);
    let mut halves: Vec<Option<Halves>> = vec![None; count];
    for (s, seam) in seams.iter().enumerate() {
        let place = &mut halves[surface.curve(s) as usize];
        if place.is_none() {
            let (patch, k) = (seam.first.patch, usize::from(seam.first.edge));
            let ends = [k, (k + 1) % 3].map(|c| surface.corners(patch)[c]);
            *place = Some(write_wire(&wire(surface, patch, k), ends, corners, entities)?);
        }
    }
    Ok(halves.into_iter().map(Option::unwrap_or_default).collect())
}

/// The cubic on edge k of a patch, through four of its points.
fn wire(surface: &dyn Surface, patch: PatchId, k: usize) -> [Point3; WIRE + 1] {
    let at = |t: f64| {
        let mut l = [0.0; 3];
        (l[k], l[(k + 1) % 3]) = (1.0 - t, t);
        surface.sample(patch, [l[0], l[1]]).point
    };
    let [p0, p1, p2, p3] = [0.0, 1.0 / 3.0, 2.0 / 3.0, 1.0].map(at);
    let inner = |near: Point3, by: Point3, to: Point3, far: Point3| {
        (18.0 * by - 9.0 * to - 5.0 * near + 2.0 * far) / 6.0
    };
    [p0, inner(p0, p1, p2, p3), inner(p3, p2, p1, p0), p3]
}

fn write_wire<W: Write>(
    wire: &[Point3; WIRE + 1],
    ends: [u32; 2],
    corners: &[[u64; 2]],
    entities: &mut Entities<'_, W>,
) -> std::io::Result<Halves> {
    let (first, second) = split_half(wire);
    let middle_point = write_point(&second[0], entities)?;
    let middle_vertex = entities.add(&format!("VERTEX_POINT('',#{middle_point})"))?;
    let [[start_point, start], [end_point, end]] = ends.map(|v| corners[v as usize]);
    let mut edges = [0; 2];
    for (half, (points, from, to)) in [
        (first, [start_point, start], [middle_point, middle_vertex]),
        (second, [middle_point, middle_vertex], [end_point, end]),
    ]
    .into_iter()
    .enumerate()
    {
        let inner = [write_point(&points[1], entities)?, write_point(&points[2], entities)?];
        let curve = entities.add(&format!(
            "B_SPLINE_CURVE_WITH_KNOTS('',{WIRE},(#{},#{},#{},#{}),.UNSPECIFIED.,.F.,.F.,(4,4),(0.,1.),.UNSPECIFIED.)",
            from[0], inner[0], inner[1], to[0]
        ))?;
        edges[half] = entities.add(&format!("EDGE_CURVE('',#{},#{},#{curve},.T.)", from[1], to[1]))?;
    }
    Ok(Halves { start: ends[0], middle_point, middle_vertex, edges })
}

/// Control points of a cut with their weights, and its EDGE_CURVE.
struct Cut {
    points: Vec<u64>,
    edge: u64,
}

/// The four faces of a patch.
fn write_patch<W: Write>(
    surface: &dyn Surface,
    patch: PatchId,
    corners: &[[u64; 2]],
    sides: &[Halves; 3],
    facing: Facing,
    entities: &mut Entities<'_, W>,
) -> Result<[u64; 4], WriteError> {
    let PatchForm::RationalTriangle { degree, weighted } = surface.form(patch) else {
        return Err(WriteError::NoNet { format: "STEP", patch: patch.0 });
    };
    let vertices = surface.corners(patch);
    let pieces = pieces(degree, weighted);
    let cut = |k: usize, entities: &mut Entities<'_, W>| {
        write_cut(&pieces[k], sides[k], sides[(k + 2) % 3], entities)
    };
    let cuts = [cut(0, entities)?, cut(1, entities)?, cut(2, entities)?];
    let mut faces = [0; 4];
    for k in 0..3 {
        let piece = &pieces[k];
        let [m, n] = piece.degrees;
        let tip = corners[vertices[k] as usize][0];
        let points = net(piece, entities, |i, j| match i {
            0 => Some(tip),
            _ if i == m => Some(cuts[k].points[j]),
            _ => None,
        })?;
        debug_assert_eq!(points.len(), (m + 1) * (n + 1));
        // Along edge k from the corner, over the cut, back along edge k + 2.
        let half = |side: usize, from_corner: bool| half_edge(&sides[side], vertices[k], from_corner);
        let border = [half(k, true), (cuts[k].edge, true), half((k + 2) % 3, false)];
        faces[k] = write_face(piece, &points, &border, facing, entities)?;
    }
    let middle = &pieces[3];
    let [m, n] = middle.degrees;
    let points = net(middle, entities, |i, j| match (i, j) {
        (0, _) => Some(sides[0].middle_point),
        (_, 0) => Some(cuts[1].points[n - i]),
        (_, j) if j == n => Some(cuts[0].points[i]),
        (i, _) if i == m => Some(cuts[2].points[n - j]),
        _ => None,
    })?;
    let border = [(cuts[1].edge, false), (cuts[2].edge, false), (cuts[0].edge, false)];
    faces[3] = write_face(middle, &points, &border, facing, entities)?;
    Ok(faces)
}

/// The half of a side at a corner, and whether it runs from the corner (to the midpoint) or to it.
fn half_edge(side: &Halves, corner: u32, from_corner: bool) -> (u64, bool) {
    let is_start = side.start == corner;
    (side.edges[usize::from(!is_start)], is_start == from_corner)
}

/// The side s = 1 of the piece at a corner, from the midpoint of one edge to that of another.
fn write_cut<W: Write>(
    piece: &Piece,
    from: Halves,
    to: Halves,
    entities: &mut Entities<'_, W>,
) -> std::io::Result<Cut> {
    let far = piece.far_side();
    let n = far.len() - 1;
    let mut points = vec![from.middle_point];
    for p in &far[1..n] {
        points.push(write_point(&(p.xyz() / p.w), entities)?);
    }
    points.push(to.middle_point);
    let curve = entities.add(&format!(
        "(BOUNDED_CURVE()B_SPLINE_CURVE({n},({}),.UNSPECIFIED.,.F.,.F.)\
         B_SPLINE_CURVE_WITH_KNOTS(({1},{1}),(0.,1.),.UNSPECIFIED.)CURVE()GEOMETRIC_REPRESENTATION_ITEM()\
         RATIONAL_B_SPLINE_CURVE(({2}))REPRESENTATION_ITEM(''))",
        references(&points),
        n + 1,
        weights(far),
    ))?;
    let edge = entities
        .add(&format!("EDGE_CURVE('',#{},#{},#{curve},.T.)", from.middle_vertex, to.middle_vertex))?;
    Ok(Cut { points, edge })
}

/// Numbers of the control points of a piece, row after row: those that are there already, and new ones.
fn net<W: Write>(
    piece: &Piece,
    entities: &mut Entities<'_, W>,
    shared: impl Fn(usize, usize) -> Option<u64>,
) -> std::io::Result<Vec<u64>> {
    let [m, n] = piece.degrees;
    let places = (0..=m).flat_map(|i| (0..=n).map(move |j| (i, j)));
    places
        .map(|(i, j)| match shared(i, j) {
            Some(id) => Ok(id),
            None => {
                let p = piece.point(i, j);
                write_point(&(p.xyz() / p.w), entities)
            }
        })
        .collect()
}

fn write_face<W: Write>(
    piece: &Piece,
    points: &[u64],
    border: &[(u64, bool); 3],
    facing: Facing,
    entities: &mut Entities<'_, W>,
) -> std::io::Result<u64> {
    // A turned face has its two parameters exchanged.
    let [m, n] = piece.degrees;
    let [rows, columns] = if facing == Facing::Kept { [m, n] } else { [n, m] };
    let place = |a: usize, b: usize| if facing == Facing::Kept { a * (n + 1) + b } else { b * (n + 1) + a };
    let (mut ids, mut of_weights) = (Vec::new(), Vec::new());
    for a in 0..=rows {
        let row: Vec<usize> = (0..=columns).map(|b| place(a, b)).collect();
        ids.push(format!("({})", references(&row.iter().map(|p| points[*p]).collect::<Vec<_>>())));
        of_weights.push(format!("({})", weights(&row.iter().map(|p| piece.points[*p]).collect::<Vec<_>>())));
    }
    let surface = entities.add(&format!(
        "(BOUNDED_SURFACE()B_SPLINE_SURFACE({rows},{columns},({}),.UNSPECIFIED.,.F.,.F.,.F.)\
         B_SPLINE_SURFACE_WITH_KNOTS(({1},{1}),({2},{2}),(0.,1.),(0.,1.),.UNSPECIFIED.)\
         GEOMETRIC_REPRESENTATION_ITEM()RATIONAL_B_SPLINE_SURFACE(({3}))REPRESENTATION_ITEM('')SURFACE())",
        ids.join(","),
        rows + 1,
        columns + 1,
        of_weights.join(","),
    ))?;
    let mut border = *border;
    if facing == Facing::Turned {
        border.reverse();
        border.iter_mut().for_each(|(_, forward)| *forward = !*forward);
    }
    let mut oriented = Vec::new();
    for (edge, forward) in border {
        let sense = if forward { ".T." } else { ".F." };
        oriented.push(entities.add(&format!("ORIENTED_EDGE('',*,*,#{edge},{sense})"))?);
    }
    let path = entities.add(&format!("EDGE_LOOP('',({}))", references(&oriented)))?;
    let bound = entities.add(&format!("FACE_OUTER_BOUND('',#{path},.T.)"))?;
    entities.add(&format!("ADVANCED_FACE('',(#{bound}),#{surface},.T.)"))
}

fn write_point<W: Write>(p: &Point3, entities: &mut Entities<'_, W>) -> std::io::Result<u64> {
    entities.add(&format!("CARTESIAN_POINT('',({}))", reals(p.iter().copied())))
}

fn weights(points: &[Vec4]) -> String {
    reals(points.iter().map(|p| p.w))
}

fn reals(numbers: impl Iterator<Item = f64>) -> String {
    let mut text = Vec::new();
    for (i, x) in numbers.enumerate() {
        if i > 0 {
            text.push(b',');
        }
        push_real(&mut text, x);
    }
    // Digits, points and commas only.
    String::from_utf8_lossy(&text).into_owned()
}

fn references(ids: &[u64]) -> String {
    ids.iter().map(|id| format!("#{id}")).collect::<Vec<_>>().join(",")
}
