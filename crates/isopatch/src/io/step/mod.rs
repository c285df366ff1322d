//! STEP (ISO 10303-21, AP242): solids of untrimmed B-spline faces.
//!
//! Each Bézier triangle becomes three bi-degree-7 faces, see [`crate::bernstein::quads`]. A seam is two edges, each
//! an EDGE_CURVE whose control points are the very CARTESIAN_POINTs of the surface borders on both sides, so the
//! file is watertight bit for bit and needs no curves in parameter space. Rational triangles are in `rational.rs`.

mod bodies;
mod decimals;
mod geometry;
mod numbering;
mod product;
mod rational;

use super::net::{DEGREE, Net, nets};
use super::text::Buffers;
use super::{Unit, WriteError};
use crate::bernstein::index;
use crate::geom::Point3;
use crate::surface::{PatchId, Seam, Surface};
use bodies::Body;
use decimals::Decimals;
use geometry::Facing;
use numbering::Numbering;
use product::Entities;
use std::io::Write;

/// What a STEP file says besides the surface.
#[derive(Clone, Debug, PartialEq)]
pub struct StepOptions {
    /// Length of a model unit. Default: millimetre.
    pub unit: Unit,
    /// Name of the product. Default: "isopatch".
    pub name: String,
    /// Distance under which readers may take points for equal, in millimetres whatever the unit. Positive and finite.
    /// Default 1e-7, the smallest that OpenCASCADE works with.
    pub uncertainty: f64,
    /// Time that the header tells, in seconds since 1970 began (UTC). Default: the start of the year 2000, so that files with the
    /// same content have the same bytes.
    pub time: u64,
}

impl Default for StepOptions {
    fn default() -> Self {
        Self { unit: Unit::Mm, name: "isopatch".to_owned(), uncertainty: 1e-7, time: product::YEAR_2000 }
    }
}

/// Writes a surface: a MANIFOLD_SOLID_BREP for each solid, a BREP_WITH_VOIDS where it has cavities, and a
/// SHELL_BASED_SURFACE_MODEL for each component with a boundary.
///
/// Cavities are closed components that face inward; each belongs to the smallest solid around it.
///
/// # Errors
/// [`WriteError::Empty`], [`WriteError::Degree`], [`WriteError::NotFinite`], [`WriteError::InsideOut`],
/// [`WriteError::Uncertainty`], or what the output or the sharing of the patches gives.
pub fn write_step(
    surface: &dyn Surface,
    options: &StepOptions,
    out: &mut impl Write,
) -> Result<(), WriteError> {
    if surface.patch_count() == 0 {
        return Err(WriteError::Empty { format: "STEP" });
    }
    if !(options.uncertainty > 0.0 && options.uncertainty.is_finite()) {
        return Err(WriteError::Uncertainty(options.uncertainty));
    }
    let bodies = bodies::bodies(surface)?;
    if rational::is_rational(surface) {
        return rational::write(surface, &bodies, options, out);
    }
    let nets = nets(surface, "STEP")?;
    let ids = Numbering::new(surface)?;
    product::write_header(out, options)?;
    let mut buffers = Buffers::default();
    // Everything written is a convex combination of these.
    let largest = nets.iter().flat_map(|net| net.iter().map(|p| p.amax())).fold(0.0, f64::max);
    let decimals = Decimals::of(largest);
    write_corners(surface, &nets, &ids, decimals, &mut buffers, out)?;
    write_seams(surface, &nets, &ids, decimals, &mut buffers, out)?;
    let facings = facings(surface, &bodies);
    buffers.write_items(out, nets.len(), |p, text| {
        geometry::push_patch(text, &ids, decimals, PatchId(p as u32), nets[p], facings[p]);
    })?;
    let mut entities = Entities { next: ids.end(), out };
    let faces = |patches: &[PatchId]| {
        let mut text = Vec::new();
        geometry::push_references(&mut text, patches.iter().flat_map(|p| (0..3).map(|q| ids.face(*p, q))));
        // Digits, signs and commas only.
        String::from_utf8_lossy(&text).into_owned()
    };
    write_bodies(&bodies, &faces, options, &mut entities)?;
    out.write_all(b"ENDSEC;\nEND-ISO-10303-21;\n")?;
    Ok(())
}

fn write_corners(
    surface: &dyn Surface,
    nets: &[&Net],
    ids: &Numbering,
    decimals: Decimals,
    buffers: &mut Buffers,
    out: &mut impl Write,
) -> std::io::Result<()> {
    let mut points = vec![Point3::zeros(); ids.lattice().corner_count()];
    for (patch, net) in surface.patches().zip(nets) {
        for (c, corner) in surface.corners(patch).into_iter().enumerate() {
            points[corner as usize] = net[index::row(DEGREE, c, 0, 0)];
        }
    }
    buffers.write_items(out, points.len(), |c, text| {
        geometry::push_corner(text, ids, decimals, c as u32, &points[c])
    })
}

fn write_seams(
    surface: &dyn Surface,
    nets: &[&Net],
    ids: &Numbering,
    decimals: Decimals,
    buffers: &mut Buffers,
    out: &mut impl Write,
) -> std::io::Result<()> {
    let seams = surface.seams();
    buffers.write_items(out, seams.len(), |s, text| {
        let (row, ends) = seam_row(surface, nets, &seams[s]);
        geometry::push_seam(text, ids, decimals, s as u32, &row, ends);
    })
}

/// Control points along a seam, from its first side, and its end corners.
fn seam_row(surface: &dyn Surface, nets: &[&Net], seam: &Seam) -> ([Point3; DEGREE + 1], [u32; 2]) {
    let (patch, edge) = (seam.first.patch, seam.first.edge as usize);
    let (net, corners) = (nets[patch.index()], surface.corners(patch));
    let mut row: [Point3; DEGREE + 1] = std::array::from_fn(|m| net[index::row(DEGREE, edge, 0, m)]);
    let mut ends = [corners[edge], corners[(edge + 1) % 3]];
    if seam.first.reversed {
        row.reverse();
        ends.reverse();
    }
    (row, ends)
}

/// The faces of a cavity are turned, because ISO 10303-42 has a void shell face out of the void and then reverses
/// it by its ORIENTED_CLOSED_SHELL.
fn facings(surface: &dyn Surface, bodies: &[Body]) -> Vec<Facing> {
    let mut facings = vec![Facing::Kept; surface.patch_count()];
    for body in bodies {
        if let Body::Solid { voids, .. } = body {
            voids.iter().flatten().for_each(|p| facings[p.index()] = Facing::Turned);
        }
    }
    facings
}

/// Writes the bodies and what refers to them; `faces` gives the list of the faces of some patches.
fn write_bodies<W: Write>(
    bodies: &[Body],
    faces: &dyn Fn(&[PatchId]) -> String,
    options: &StepOptions,
    entities: &mut Entities<'_, W>,
) -> std::io::Result<()> {
    let (mut solids, mut sheets) = (Vec::new(), Vec::new());
    for body in bodies {
        match body {
            Body::Solid { outer, voids } => {
                let outer = entities.add(&format!("CLOSED_SHELL('',{})", faces(outer)))?;
                let mut reversed = Vec::new();
                for void in voids {
                    let shell = entities.add(&format!("CLOSED_SHELL('',{})", faces(void)))?;
                    reversed.push(entities.add(&format!("ORIENTED_CLOSED_SHELL('',*,#{shell},.F.)"))?);
                }
                solids.push(entities.add(&match reversed.is_empty() {
                    true => format!("MANIFOLD_SOLID_BREP('',#{outer})"),
                    false => format!("BREP_WITH_VOIDS('',#{outer},({}))", references(&reversed)),
                })?);
            }
            Body::Sheet(patches) => {
                let shell = entities.add(&format!("OPEN_SHELL('',{})", faces(patches)))?;
                sheets.push(entities.add(&format!("SHELL_BASED_SURFACE_MODEL('',(#{shell}))"))?);
            }
        }
    }
    let context = entities.context(options)?;
    let placement = entities.placement()?;
    let mut representations = Vec::new();
    for (kind, items) in
        [("ADVANCED_BREP_SHAPE_REPRESENTATION", solids), ("MANIFOLD_SURFACE_SHAPE_REPRESENTATION", sheets)]
    {
        if !items.is_empty() {
            let items = references(&items);
            representations.push(entities.add(&format!("{kind}('',(#{placement},{items}),#{context})"))?);
        }
    }
    entities.product(options, &representations)
}

fn references(ids: &[u64]) -> String {
    ids.iter().map(|id| format!("#{id}")).collect::<Vec<_>>().join(",")
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::geom::Vec3;
    use crate::golden::{flat_triangle, inverted, joined, scaled, sphere};
    use crate::spline::TriangularSpline;
    use std::collections::{HashMap, HashSet};

    fn written(surface: &dyn Surface) -> String {
        let mut bytes = Vec::new();
        write_step(surface, &StepOptions::default(), &mut bytes).unwrap();
        String::from_utf8(bytes).unwrap()
    }

    /// Number and text of each entity.
    fn entities(file: &str) -> Vec<(u64, &str)> {
        file.lines()
            .filter_map(|l| l.strip_prefix('#'))
            .map(|l| l.split_once('=').unwrap())
            .map(|(id, text)| (id.parse().unwrap(), text))
            .collect()
    }

    #[test]
    fn entities_are_numbered_from_one_and_refer_to_existing_ones() {
        let cavity = inverted(&scaled(&sphere(), 0.5, Vec3::zeros()));
        for surface in [sphere(), flat_triangle(), joined(&[sphere(), cavity])] {
            let file = written(&surface);
            let entities = entities(&file);
            assert!(entities.iter().enumerate().all(|(k, (id, _))| *id == k as u64 + 1));
            for (_, text) in &entities {
                for reference in text.split('#').skip(1) {
                    let digits = reference.split(|c: char| !c.is_ascii_digit()).next().unwrap();
                    assert!((1..=entities.len()).contains(&digits.parse().unwrap()), "{text}");
                }
            }
        }
    }

    #[test]
    fn edges_are_used_once_in_each_direction() {
        let file = written(&sphere());
        let mut uses: HashMap<&str, Vec<bool>> = HashMap::new();
        let mut kinds: HashMap<&str, usize> = HashMap::new();
        for (_, text) in entities(&file) {
            *kinds.entry(text.split('(').next().unwrap()).or_default() += 1;
            if let Some(rest) = text.strip_prefix("ORIENTED_EDGE('',*,*,") {
                let (edge, forward) = rest.split_once(',').unwrap();
                uses.entry(edge).or_default().push(forward.starts_with(".T."));
            }
        }
        assert!(uses.values().all(|u| u.len() == 2 && u[0] != u[1]));
        // F = 3f, E = 2e + 3f, V = v + e + f for v, e, f = 12, 30, 20.
        for (kind, count) in
            [("ADVANCED_FACE", 60), ("EDGE_CURVE", 120), ("VERTEX_POINT", 62), ("CLOSED_SHELL", 1)]
        {
            assert_eq!(kinds[kind], count, "{kind}");
        }
    }

    #[test]
    fn points_are_written_once() {
        let file = written(&sphere());
        let points: Vec<_> = entities(&file)
            .into_iter()
            .map(|(_, text)| text)
            .filter(|t| t.starts_with("CARTESIAN_POINT"))
            .collect();
        let distinct: HashSet<_> = points.iter().collect();
        assert_eq!(points.len(), 12 + 30 * 13 + 20 * 127 + 1);
        assert_eq!(points.len(), distinct.len());
    }

    #[test]
    fn what_cannot_be_written_is_named() {
        let write = |surface: &TriangularSpline, uncertainty| {
            let options = StepOptions { uncertainty, ..StepOptions::default() };
            write_step(surface, &options, &mut Vec::new()).unwrap_err()
        };
        let mut broken = sphere();
        broken.nets[4][7].y = f64::NAN;
        assert!(matches!(write(&broken, 1e-7), WriteError::NotFinite { what: "patch", index: 4 }));
        assert!(matches!(write(&inverted(&sphere()), 1e-7), WriteError::InsideOut { patch: 0 }));
        assert!(matches!(write(&sphere(), 0.0), WriteError::Uncertainty(0.0)));
    }
}
