//! Which components are solids, which are cavities of which solid, and which are open.

use crate::geom::{Aabb, Point3};
use crate::io::WriteError;
use crate::surface::{PatchId, Surface};
use crate::tessellate::{TessellateOptions, Tessellation, tessellate};
use rayon::prelude::*;
use std::f64::consts::PI;

/// Intervals a patch edge of the tessellation that decides about nesting. It has to be fine enough for the sign of
/// a volume and for components not to seem to intersect; patches turn by far less than a right angle.
const RESOLUTION: usize = 4;

/// A connected part of the surface, or a solid made of several.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum Body {
    /// The solid between an outer component and the cavities in it.
    Solid {
        /// Patches that face out of the solid and enclose it.
        outer: Vec<PatchId>,
        /// Patches of each cavity, facing into the cavity.
        voids: Vec<Vec<PatchId>>,
    },
    /// A component with a boundary.
    Sheet(Vec<PatchId>),
}

/// Triangles of a patch in the tessellation.
const TRIANGLES: usize = RESOLUTION * RESOLUTION;
/// Patches whose solid angles are added up first: sums of fixed length keep the result independent of the number of threads.
const PATCHES_PER_SUM: usize = 64;

/// A component, tessellated.
struct Component<'a> {
    patches: Vec<PatchId>,
    mesh: &'a Tessellation,
    bounds: Aabb,
    volume: f64,
}

/// Sorts the components of a surface into bodies, in order of their first patches.
///
/// A closed component of positive volume is a solid of its own; one of negative volume is a cavity of the smallest
/// solid around it.
pub fn bodies(surface: &dyn Surface) -> Result<Vec<Body>, WriteError> {
    let parts = components(surface);
    let mesh = tessellate(surface, &TessellateOptions { resolution: RESOLUTION })?;
    let closed: Vec<Option<Component<'_>>> = parts
        .iter()
        .map(|(patches, is_closed)| is_closed.then(|| Component::new(patches.clone(), &mesh)))
        .collect();
    let mut voids = vec![Vec::new(); parts.len()];
    for cavity in closed.iter().flatten().filter(|c| c.volume < 0.0) {
        voids[enclosing(cavity, &closed)?].push(cavity.patches.clone());
    }
    let mut bodies = Vec::new();
    for (k, (patches, is_closed)) in parts.into_iter().enumerate() {
        match &closed[k] {
            Some(component) if component.volume < 0.0 => {}
            _ if is_closed => {
                bodies.push(Body::Solid { outer: patches, voids: std::mem::take(&mut voids[k]) })
            }
            _ => bodies.push(Body::Sheet(patches)),
        }
    }
    Ok(bodies)
}

/// Connected components in order of their first patches, and whether they have no boundary.
fn components(surface: &dyn Surface) -> Vec<(Vec<PatchId>, bool)> {
    let mut neighbours = vec![Vec::new(); surface.patch_count()];
    let mut on_boundary = vec![false; surface.patch_count()];
    for seam in surface.seams() {
        let a = seam.first.patch.index();
        match seam.second.map(|s| s.patch.index()) {
            Some(b) => {
                neighbours[a].push(b);
                neighbours[b].push(a);
            }
            None => on_boundary[a] = true,
        }
    }
    let mut seen = vec![false; surface.patch_count()];
    let mut parts = Vec::new();
    for seed in 0..surface.patch_count() {
        if seen[seed] {
            continue;
        }
        seen[seed] = true;
        let mut part = vec![seed];
        let mut next = 0;
        while next < part.len() {
            for &b in &neighbours[part[next]] {
                if !seen[b] {
                    seen[b] = true;
                    part.push(b);
                }
            }
            next += 1;
        }
        part.sort_unstable();
        let closed = !part.iter().any(|p| on_boundary[*p]);
        parts.push((part.into_iter().map(|p| PatchId(p as u32)).collect(), closed));
    }
    parts
}

/// Position of the smallest outer component around a cavity.
fn enclosing(cavity: &Component<'_>, closed: &[Option<Component<'_>>]) -> Result<usize, WriteError> {
    let inside = corners(cavity.mesh, cavity.patches[0], 0)[0];
    let candidates = closed.iter().enumerate().filter_map(|(k, c)| c.as_ref().map(|c| (k, c)));
    candidates
        .filter(|(_, c)| c.volume > 0.0 && c.bounds.contains(&inside) && c.winding_number(&inside) > 0.5)
        .min_by(|(_, a), (_, b)| a.volume.total_cmp(&b.volume))
        .map(|(k, _)| k)
        .ok_or(WriteError::InsideOut { patch: cavity.patches[0].0 })
}

/// Corners of a triangle of a patch.
fn corners(mesh: &Tessellation, patch: PatchId, triangle: usize) -> [Point3; 3] {
    let [a, b, c] = mesh.triangles[patch.index() * TRIANGLES + triangle];
    [mesh.positions[a as usize], mesh.positions[b as usize], mesh.positions[c as usize]]
}

fn triangles(mesh: &Tessellation, patches: &[PatchId]) -> impl Iterator<Item = [Point3; 3]> {
    patches.iter().flat_map(|p| (0..TRIANGLES).map(|t| corners(mesh, *p, t)))
}

impl<'a> Component<'a> {
    fn new(patches: Vec<PatchId>, mesh: &'a Tessellation) -> Self {
        let origin = corners(mesh, patches[0], 0)[0];
        let volume = triangles(mesh, &patches)
            .map(|[a, b, c]| (a - origin).cross(&(b - origin)).dot(&(c - origin)) / 6.0);
        let volume = volume.sum();
        let bounds = triangles(mesh, &patches).flatten().fold(Aabb::EMPTY, |b, p| b.including(&p));
        Self { patches, mesh, bounds, volume }
    }

    /// How often the component winds around a point: 1 inside, 0 outside. The sum of the solid angles of the
    /// triangles, each by van Oosterom & Strackee (1983), needs no care where a ray would meet an edge.
    fn winding_number(&self, p: &Point3) -> f64 {
        let solid_angle = |t: [Point3; 3]| {
            let [a, b, c] = t.map(|q| q - p);
            let (la, lb, lc) = (a.norm(), b.norm(), c.norm());
            let denominator = la * lb * lc + a.dot(&b) * lc + b.dot(&c) * la + c.dot(&a) * lb;
            2.0 * a.cross(&b).dot(&c).atan2(denominator)
        };
        let partial: Vec<f64> = (self.patches.par_chunks(PATCHES_PER_SUM))
            .map(|patches| triangles(self.mesh, patches).map(solid_angle).sum())
            .collect();
        partial.iter().sum::<f64>() / (4.0 * PI)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::geom::Vec3;
    use crate::golden::{flat_triangle, inverted, joined, scaled, sphere};

    fn shape(bodies: &[Body]) -> Vec<(usize, Vec<usize>)> {
        let size = |b: &Body| match b {
            Body::Solid { outer, voids } => (outer.len(), voids.iter().map(Vec::len).collect()),
            Body::Sheet(patches) => (patches.len(), vec![]),
        };
        bodies.iter().map(size).collect()
    }

    #[test]
    fn cavities_belong_to_the_smallest_solid_around_them() {
        let at = |r: f64, x: f64| scaled(&sphere(), r, Vec3::new(x, 0.0, 0.0));
        // A shell in a cavity of a larger shell, and a solid beside them with a cavity of its own.
        let parts = [
            inverted(&at(1.0, 0.1)),
            at(4.0, 0.0),
            inverted(&at(3.0, 0.0)),
            at(2.0, 0.0),
            at(2.0, 10.0),
            inverted(&at(1.0, 10.0)),
        ];
        let found = bodies(&joined(&parts)).unwrap();
        assert_eq!(shape(&found), [(20, vec![20]), (20, vec![20]), (20, vec![20])]);
        let first = |b: &Body| match b {
            Body::Solid { outer, voids } => (outer[0].0 / 20, voids[0][0].0 / 20),
            Body::Sheet(p) => (p[0].0 / 20, 99),
        };
        assert_eq!(found.iter().map(first).collect::<Vec<_>>(), [(1, 2), (3, 0), (4, 5)]);
    }

    #[test]
    fn open_components_are_sheets() {
        let found = bodies(&joined(&[flat_triangle(), sphere()])).unwrap();
        assert!(
            matches!(&found[..], [Body::Sheet(a), Body::Solid { outer, .. }] if a.len() == 1 && outer.len() == 20)
        );
    }

    #[test]
    fn a_cavity_in_nothing_is_named() {
        let far = scaled(&sphere(), 1.0, Vec3::new(9.0, 0.0, 0.0));
        let error = bodies(&joined(&[sphere(), inverted(&far)])).unwrap_err();
        assert!(matches!(error, WriteError::InsideOut { patch: 20 }));
    }
}
