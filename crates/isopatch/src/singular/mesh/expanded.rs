//! The triangulation of Algorithms 1 and 2 (Bajaj & Xu 1997, §4) in place of the conforming one: faster, and proven by nothing.

use super::normals::set_normals;
use super::singular_mesh::{LowerPart, SingularMesh, VertexKind};
use super::triangulate::{FLOOR_SHARE, Triangulated, median_gradient};
use crate::base::BoxSides;
use crate::expand::{Check, ExpandError, ExpandOptions, Walls, expand};
use crate::field::{Field, Polynomial};
use crate::geom::{Aabb, Point3};
use crate::singular::{LowerDimensional, PointKind, SingularSet};
use std::collections::BTreeMap;

/// Fewest segments of an arc: one between two special points would say nothing of its shape.
const LEAST_SEGMENTS: usize = 2;
/// Fewest of a closed arc.
const LEAST_OF_LOOP: usize = 3;

/// The surface expanded from seeds and from its singular set, and what the check of it says.
///
/// # Errors
/// [`ExpandError`].
pub fn triangulate_by_expansion(
    field: &dyn Field,
    polynomial: &Polynomial,
    set: &SingularSet,
    bounds: &Aabb,
    seeds: &[Point3],
    options: &ExpandOptions,
) -> Result<(Triangulated, Check), ExpandError> {
    let Built { walls, mut kinds, lower } = walls(set, options.segment * bounds.diagonal());
    let made = expand(field, polynomial, bounds, &walls, seeds, options)?;
    kinds.resize(made.positions.len(), VertexKind::Regular);
    let used: BTreeMap<[u32; 2], ()> = made
        .triangles
        .iter()
        .flat_map(|t| [0, 1, 2].map(|k| [t[k].min(t[(k + 1) % 3]), t[k].max(t[(k + 1) % 3])]))
        .map(|edge| (edge, ()))
        .collect();
    let singular_edges = walls.segments.iter().filter(|s| used.contains_key(*s)).copied().collect();
    let sides = made.positions.iter().map(|p| BoxSides::of(p, bounds)).collect();
    let mut mesh = SingularMesh {
        positions: made.positions,
        vertices: kinds,
        sides,
        triangles: made.triangles,
        normals: Vec::new(),
        singular_edges,
        lower,
    };
    set_normals(field, &mut mesh);
    let gradient_floor = FLOOR_SHARE * median_gradient(field, &mesh.positions);
    let raw_triangles = mesh.triangles.len();
    let doubtful = Vec::new();
    let made_of = Triangulated { mesh, raw_triangles, cells: 0, uncertain: 0, gradient_floor, doubtful };
    Ok((made_of, made.check))
}

/// The walls of a singular set.
struct Built {
    walls: Walls,
    kinds: Vec<VertexKind>,
    lower: Vec<LowerPart>,
}

fn walls(set: &SingularSet, longest: f64) -> Built {
    let (mut walls, mut kinds, mut lower) = (Walls::default(), Vec::new(), Vec::new());
    for part in &set.lower_dimensional {
        lower.push(match part {
            LowerDimensional::Point(i) => LowerPart::Point(set.points[*i].at),
            LowerDimensional::Curve(i) => {
                LowerPart::Stick(set.curves[*i].samples.iter().map(|s| s.at).collect())
            }
        });
    }
    for (i, point) in set.points.iter().enumerate().filter(|(_, p)| p.kind != PointKind::Isolated) {
        walls.add_point(point.at);
        kinds.push(VertexKind::Isolated(i as u32));
    }
    let mut special: BTreeMap<usize, u32> = BTreeMap::new();
    for (i, curve) in set.curves.iter().enumerate() {
        if set.lower_dimensional.contains(&LowerDimensional::Curve(i)) {
            continue;
        }
        let mut samples: Vec<Point3> = curve.samples.iter().map(|s| s.at).collect();
        let ends = match curve.ends {
            Some(ends) => ends.map(|end| {
                *special.entry(end).or_insert_with(|| {
                    kinds.push(VertexKind::Special(end as u32));
                    walls.add_point(set.special[end].at)
                })
            }),
            None => {
                let Some(first) = samples.first().copied() else { continue };
                samples.push(first);
                kinds.push(VertexKind::OnCurve(i as u32));
                [walls.add_point(first); 2]
            }
        };
        let least = if ends[0] == ends[1] { LEAST_OF_LOOP } else { LEAST_SEGMENTS };
        walls.add_arc(ends, &samples, longest, least);
        kinds.resize(walls.points.len(), VertexKind::OnCurve(i as u32));
    }
    Built { walls, kinds, lower }
}
