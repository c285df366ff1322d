//! STEP (ISO 10303-21, AP242): solids of untrimmed B-spline faces.
//!
//! Each Bézier triangle becomes three bi-degree-7 faces, see [`crate::bernstein::quads`]. A seam is two edges, each
//! an EDGE_CURVE whose control points are the very CARTESIAN_POINTs of the surface borders on both sides, so the
//! file is watertight bit for bit and needs no curves in parameter space.

mod bodies;
mod geometry;
mod numbering;
mod product;

use super::{Unit, WriteError, text};
use crate::bernstein::index;
use crate::geom::Point3;
use crate::surface::{PatchForm, PatchId, Seam, Surface};
use bodies::Body;
use geometry::{Facing, Net};
use numbering::{DEGREE, Numbering};
use product::Entities;
use std::io::Write;

/// What a STEP file says besides the surface.
#[derive(Clone, Debug, PartialEq)]
pub struct StepOptions {
    /// Length of a model unit. Default: millimetre.
    pub unit: Unit,
    /// Name of the product. Default: "isopatch".
    pub name: String,
    /// Distance under which readers may take points for equal, in model units. Default 1e-7, the smallest that
    /// OpenCASCADE works with.
    pub uncertainty: f64,
}

impl Default for StepOptions {
    fn default() -> Self {
        Self { unit: Unit::Mm, name: "isopatch".to_owned(), uncertainty: 1e-7 }
    }
}

/// Writes a surface: a MANIFOLD_SOLID_BREP for each solid, a BREP_WITH_VOIDS where it has cavities, and a
/// SHELL_BASED_SURFACE_MODEL for each component with a boundary.
///
/// Cavities are closed components that face inward; each belongs to the smallest solid around it.
pub fn write_step(surface: &dyn Surface, options: &StepOptions, out: &mut impl Write) -> Result<(), WriteError> {
    for patch in surface.patches() {
        net(surface, patch)?;
    }
    let bodies = bodies::bodies(surface)?;
    let ids = Numbering::new(surface)?;
    product::write_header(out, options)?;
    write_corners(surface, &ids, out)?;
    write_seams(surface, &ids, out)?;
    write_patches(surface, &ids, &facings(surface, &bodies), out)?;
    let mut entities = Entities { next: ids.end(), out };
    write_bodies(&bodies, &ids, options, &mut entities)?;
    out.write_all(b"ENDSEC;\nEND-ISO-10303-21;\n")?;
    Ok(())
}

/// The control points of a patch, checked.
fn net(surface: &dyn Surface, patch: PatchId) -> Result<&Net, WriteError> {
    let PatchForm::BezierTriangle { degree, net } = surface.form(patch);
    let wrong = WriteError::Degree { format: "STEP", patch: patch.0, degree };
    if degree != DEGREE {
        return Err(wrong);
    }
    if !net.iter().all(|p| p.iter().all(|c| c.is_finite())) {
        return Err(WriteError::NotFinite { what: "patch", index: patch.index() });
    }
    net.try_into().map_err(|_| wrong)
}

fn write_corners(surface: &dyn Surface, ids: &Numbering, out: &mut impl Write) -> Result<(), WriteError> {
    let mut points = vec![Point3::zeros(); ids.lattice().corner_count()];
    for patch in surface.patches() {
        let net = net(surface, patch)?;
        for (c, corner) in surface.corners(patch).into_iter().enumerate() {
            points[corner as usize] = net[index::row(DEGREE, c, 0, 0)];
        }
    }
    let corner = |c: usize, text: &mut Vec<u8>| geometry::push_corner(text, ids, c as u32, &points[c]);
    Ok(text::write_items(out, points.len(), corner)?)
}

fn write_seams(surface: &dyn Surface, ids: &Numbering, out: &mut impl Write) -> Result<(), WriteError> {
    let seams = surface.seams();
    let rows: Vec<_> = seams.iter().map(|s| seam_row(surface, s)).collect::<Result<_, _>>()?;
    let seam = |s: usize, text: &mut Vec<u8>| geometry::push_seam(text, ids, s as u32, &rows[s].0, rows[s].1);
    Ok(text::write_items(out, seams.len(), seam)?)
}

/// Control points along a seam, from its first side, and its end corners.
fn seam_row(surface: &dyn Surface, seam: &Seam) -> Result<([Point3; DEGREE + 1], [u32; 2]), WriteError> {
    let (net, edge) = (net(surface, seam.first.patch)?, seam.first.edge as usize);
    let corners = surface.corners(seam.first.patch);
    let mut row: [Point3; DEGREE + 1] = std::array::from_fn(|m| net[index::row(DEGREE, edge, 0, m)]);
    let mut ends = [corners[edge], corners[(edge + 1) % 3]];
    if seam.first.reversed {
        row.reverse();
        ends.reverse();
    }
    Ok((row, ends))
}

fn write_patches(
    surface: &dyn Surface,
    ids: &Numbering,
    facings: &[Facing],
    out: &mut impl Write,
) -> Result<(), WriteError> {
    let nets: Vec<&Net> = surface.patches().map(|p| net(surface, p)).collect::<Result<_, _>>()?;
    let patch = |p: usize, text: &mut Vec<u8>| {
        geometry::push_patch(text, ids, PatchId(p as u32), nets[p], facings[p]);
    };
    Ok(text::write_items(out, nets.len(), patch)?)
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

fn write_bodies<W: Write>(
    bodies: &[Body],
    ids: &Numbering,
    options: &StepOptions,
    entities: &mut Entities<'_, W>,
) -> std::io::Result<()> {
    let faces = |patches: &[PatchId]| {
        let ids: Vec<_> = patches.iter().flat_map(|p| (0..3).map(|q| format!("#{}", ids.face(*p, q)))).collect();
        ids.join(",")
    };
    let (mut solids, mut sheets) = (Vec::new(), Vec::new());
    for body in bodies {
        match body {
            Body::Solid { outer, voids } => {
                let outer = entities.add(&format!("CLOSED_SHELL('',({}))", faces(outer)))?;
                let mut reversed = Vec::new();
                for void in voids {
                    let shell = entities.add(&format!("CLOSED_SHELL('',({}))", faces(void)))?;
                    reversed.push(entities.add(&format!("ORIENTED_CLOSED_SHELL('',*,#{shell},.F.)"))?);
                }
                solids.push(entities.add(&match reversed.is_empty() {
                    true => format!("MANIFOLD_SOLID_BREP('',#{outer})"),
                    false => format!("BREP_WITH_VOIDS('',#{outer},({}))", references(&reversed)),
                })?);
            }
            Body::Sheet(patches) => {
                let shell = entities.add(&format!("OPEN_SHELL('',({}))", faces(patches)))?;
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
