//! The report of a run as JSON: schema 1. Fields are added in later versions, never renamed or removed.
//!
//! Numbers that do not exist are `null`: a distance that was not measured, or that is infinite because no point of
//! the zero set was found.

use crate::apatch::APatchFunction;
pub use crate::base::Repair;
use crate::geom::Aabb;
use crate::hull::{Class, Side};
use crate::hybrid::{Element, HybridFunction};
use crate::inspect::{APatchInspection, Inspection, Intersection, RationalInspection};
use crate::rational::RationalSurface;
use crate::surface::{Continuity, PatchId, Seam, Surface};
use serde::ser::{Serialize, SerializeMap, Serializer};
use std::collections::BTreeMap;
use std::time::Instant;

/// Version of the schema that this module writes.
pub const SCHEMA: u32 = 1;

/// Everything that is known about a run, in the order of the JSON object.
#[derive(Clone, Debug, serde::Serialize)]
pub struct Report {
    /// [`SCHEMA`].
    pub schema: u32,
    /// The input as it was given: formula, gallery name or file name.
    pub input: String,
    /// How the surface was made: `spline`, `rational` or `apatch`; none for a surface that was only read.
    pub method: Option<String>,
    /// Version of isopatch.
    pub version: String,
    /// Number of threads.
    pub threads: usize,
    /// Unit of length: `mm`, `cm`, `m` or `in`.
    pub unit: String,
    /// Was the field's sign changed, because the solid is {f > c}?
    pub negated: bool,
    /// Diagonal of the bounding box of the base mesh's vertices, in model units; lengths below are relative to it.
    pub diagonal: f64,
    /// That box: smallest and largest coordinates, in model units.
    pub bounds: [[f64; 3]; 2],
    /// The base mesh.
    pub base: BaseReport,
    /// The surface.
    pub surface: SurfaceReport,
    /// What the spline method did; none for other methods.
    pub spline: Option<SplineReport>,
    /// What the A-patch method did; none for other methods.
    pub apatch: Option<APatchReport>,
    /// What was found of singularities; none where nobody looked, or where there are none.
    pub singular: Option<SingularReport>,
    /// What the method of rational patches did; none for other methods.
    pub rational: Option<RationalReport>,
    /// What was changed to make the input fit the method.
    pub repairs: Vec<Repair>,
    /// Time of every stage.
    pub seconds: Seconds,
    /// Largest resident memory of the process so far; none where the system does not tell.
    pub peak_memory_bytes: Option<u64>,
}

/// The base mesh in numbers.
#[derive(Clone, Copy, Debug, PartialEq, Eq, serde::Serialize)]
pub struct BaseReport {
    /// Number of vertices.
    pub vertices: usize,
    /// Number of edges.
    pub edges: usize,
    /// Number of faces.
    pub faces: usize,
    /// Number of connected components.
    pub components: usize,
    /// Vertices − edges + faces.
    pub euler: i64,
    /// Total genus.
    pub genus: i64,
    /// Number of boundary loops.
    pub boundary_loops: usize,
    /// Number of isolated singular points.
    pub singular_points: usize,
    /// Number of singular curves.
    pub singular_curves: usize,
}

/// The surface in numbers: see [`Inspection`] for what they mean.
#[derive(Clone, Debug, PartialEq, serde::Serialize)]
pub struct SurfaceReport {
    /// Number of patches.
    pub patches: usize,
    /// Kind of the patches, such as `bezier-triangle-7`.
    pub kind: String,
    /// The weakest continuity that a seam claims: `G0` or `G1`.
    pub continuity: String,
    /// Has it no boundary?
    pub closed: bool,
    /// Largest gap across a seam.
    pub max_gap: f64,
    /// Largest normal jump across a seam.
    pub max_normal_jump_rad: f64,
    /// Pairs of triangles of the tessellated surface that intersect; none if that was not looked for.
    pub self_intersections: Option<usize>,
    /// The first ten of them.
    pub self_intersections_at: Vec<IntersectionReport>,
    /// Largest distance from the surface to the zero set.
    pub max_distance: Option<f64>,
    /// Largest distance from the zero set to the surface.
    pub max_distance_back: Option<f64>,
    /// Area-weighted root mean square of the distance from the surface to the zero set.
    pub rms_distance: Option<f64>,
    /// Largest angle between surface normal and field gradient.
    pub max_normal_error_rad: Option<f64>,
    /// Largest |f| / |∇f|.
    pub max_distance_first_order: Option<f64>,
    /// Area-weighted root mean square of |f| / |∇f|.
    pub rms_distance_first_order: Option<f64>,
    /// Largest distance between a vertex of the base mesh and the surface there.
    pub max_vertex_error: f64,
    /// Largest angle between the normal of a vertex and that of the surface there.
    pub max_vertex_normal_error_rad: f64,
    /// Largest difference of normal curvatures at a vertex, over max(|k|, 1/diagonal).
    pub max_vertex_curvature_error: f64,
    /// Area, in squared model units.
    pub area: f64,
    /// Volume, in cubic model units; none for an open surface.
    pub volume: Option<f64>,
    /// What is certified, not only measured.
    pub certified: Certified,
}

/// A place where the surface goes through itself.
#[derive(Clone, Copy, Debug, PartialEq, serde::Serialize)]
pub struct IntersectionReport {
    /// The two patches, or twice the same.
    pub patches: [u32; 2],
    /// The place, in model units.
    pub at: [f64; 3],
}

impl From<&Intersection> for IntersectionReport {
    fn from(found: &Intersection) -> Self {
        Self { patches: found.patches.map(|p| p.0), at: found.at.into() }
    }
}

/// Statements that outward-rounded bounds prove; none and false until something shows them.
#[derive(Clone, Copy, Debug, Default, PartialEq, serde::Serialize)]
pub struct Certified {
    /// A bound of the distance between surface and zero set.
    pub distance: Option<f64>,
    /// Has the surface the topology of the zero set in the box?
    pub topology: bool,
}

/// What the spline method did.
#[derive(Clone, Copy, Debug, Default, PartialEq, serde::Serialize)]
pub struct SplineReport {
    /// Mean number of iterations of the boundary curve solver.
    pub sqp_iterations_mean: f64,
    /// Number of curves where it did not converge.
    pub sqp_unconverged: usize,
    /// Number of curves whose tangent lengths are at a bound.
    pub curves_at_bound: usize,
    /// Number of patches that fold.
    pub folded: usize,
    /// Number of patches whose normal is over 20° off somewhere.
    pub faces_over_20deg: usize,
}

/// The singular set of a surface, and the mesh that conforms to it.
#[derive(Clone, Debug, Default, PartialEq, serde::Serialize)]
pub struct SingularReport {
    /// Number of isolated singular points.
    pub points: usize,
    /// Number of arcs of singular curves, those without sheets included.
    pub arcs: usize,
    /// Number of special points, at which arcs begin.
    pub special: usize,
    /// Number of isolated points, and of curves without sheets, which no triangle shows.
    pub lower_dimensional: [usize; 2],
    /// Number of singular edges of the mesh by the number of their triangles: 4 where two sheets cross.
    pub edges_by_valence: BTreeMap<usize, usize>,
    /// Number of smooth sheets between singular edges.
    pub sheets: usize,
    /// Cells of the octree that hold a part of the surface.
    pub cells: usize,
    /// Cells of these, beside singularities, for which no bounds show what is in them.
    pub cells_uncertain: usize,
    /// The first ten places where what was found on the boundary of a cell was not as expected.
    pub doubtful_at: Vec<[f64; 3]>,
    /// Number of triangles at more than a right angle to the surface at a corner.
    pub folded: usize,
}

/// How many elements of a mesh are of each class, see [`Class`].
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, serde::Serialize)]
pub struct ClassCounts {
    /// The surface is on the outer side.
    pub positive: usize,
    /// The surface is on the inner side.
    pub negative: usize,
    /// The surface is the element itself.
    pub zero: usize,
    /// The surface goes through.
    pub nonconvex: usize,
}

/// How many faces have cells of each kind, see [`Element`].
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, serde::Serialize)]
pub struct ElementCounts {
    /// Flat faces that are their own patches.
    pub flat: usize,
    /// A tetrahedron.
    pub triangles: usize,
    /// A pyramid.
    pub pyramids: usize,
    /// Tetrahedra between two apexes.
    pub fans: usize,
    /// Sectors, on one side or on both.
    pub sectors: usize,
    /// Polygons that were cut into triangles.
    pub cut: usize,
    /// Faces where no condition makes sure that every ray over them and their edges meets the surface once; a lattice of rays does.
    pub measured: usize,
}

/// What the A-patch method did.
#[derive(Clone, Debug, Default, PartialEq, serde::Serialize)]
pub struct APatchReport {
    /// Where normals came from: `file`, `loop`, `angle` or `area`; none if that is not known.
    pub normals: Option<String>,
    /// How long gradients are: `given`, `unit` or `recovered`; none if that is not known.
    pub gradient_lengths: Option<String>,
    /// Faces by class.
    pub faces: ClassCounts,
    /// Edges by class.
    pub edges: ClassCounts,
    /// What stands over the faces, where polygons were kept as they are; none over triangles alone.
    pub elements: Option<ElementCounts>,
    /// Number of cells over faces, on both sides.
    pub face_cells: usize,
    /// Number of cells over edges, on both sides.
    pub edge_cells: usize,
    /// Vertices around which the mesh was refined without changing its shape.
    pub vertices_refined: usize,
    /// How many faces were added, around these and around those that were rounded.
    pub faces_added: usize,
    /// Vertices around which the mesh was rounded because its own faces leave no room for a smooth surface.
    pub vertices_rounded: usize,
    /// How far new vertices around these are from the edges of the mesh at most.
    pub rounded_distance: f64,
    /// Number of vertices whose normal was moved to see the faces around them.
    pub normals_moved: usize,
    /// Number of sharp edges over which both faces end in the edge itself.
    pub creases_straight: usize,
    /// Number of sharp edges over which the faces are pulled to a common curve.
    pub creases_curved: usize,
    /// How many of both were not asked for: without them the surface would not be valid.
    pub creases_added: usize,
    /// Number of vertices that were given several normals for the same reason.
    pub corners: usize,
    /// Number of free parameters whose default was raised to the bound that is sufficient for one root on every ray.
    pub free_raised: usize,
    /// Number of vertices, faces and edges where the hull is not valid, by reason.
    pub problems: BTreeMap<String, usize>,
    /// Patches with a ray that has no root, and the first ten of them; none if that was not looked for.
    pub undefined: Option<usize>,
    /// See `undefined`.
    pub undefined_at: Vec<u32>,
    /// Patches whose normal turns from that of a small triangle by more than a right angle, and the first ten of them: the surface
    /// bends hard there. None if that was not looked for.
    pub steep: Option<usize>,
    /// See `steep`.
    pub steep_at: Vec<u32>,
    /// Patches that fold over, and the first ten of them; none if that was not looked for.
    pub folded: Option<usize>,
    /// See `folded`.
    pub folded_at: Vec<u32>,
    /// Pairs of triangles of the mesh itself that intersect, which the surface then does as well; none if no intersections of the
    /// surface were looked for or found.
    pub self_intersections_of_input: Option<usize>,
    /// Intervals along the edges of the mesh and across the patches over them, in tessellated outputs; none without one.
    pub resolution: Option<[usize; 2]>,
}

/// What the method of rational patches did.
#[derive(Clone, Debug, Default, PartialEq, Eq, serde::Serialize)]
pub struct RationalReport {
    /// Where the normals came from: `file`, `loop`, `angle` or `area` for a mesh, `field` for a formula; none if that is not known.
    pub normals: Option<String>,
    /// Number of curves on which two patches meet, but are not G1.
    pub sharp_edges: usize,
    /// Number of curves on which more than two patches meet, because sheets cross there.
    pub crossings: usize,
    /// Number of vertices at which a patch has no tangent plane.
    pub singular_vertices: usize,
    /// Patches that fold over, and the first ten of them.
    pub folded: usize,
    /// See `folded`.
    pub folded_at: Vec<u32>,
}

impl RationalReport {
    /// What an inspection found.
    pub fn new(surface: &RationalSurface, found: &RationalInspection) -> Self {
        let meets = |seam: &&Seam| seam.second.is_some() && seam.continuity == Continuity::G0;
        Self {
            normals: None,
            sharp_edges: surface.seams().iter().filter(meets).count(),
            crossings: found.crossings,
            singular_vertices: found.singular_vertices,
            folded: found.folded.len(),
            folded_at: found.folded.iter().take(NAMED_PATCHES).map(|p| p.0).collect(),
        }
    }
}

impl ClassCounts {
    fn new(classes: impl Iterator<Item = Class>) -> Self {
        let mut counts = Self::default();
        for class in classes {
            match class {
                Class::Positive => counts.positive += 1,
                Class::Negative => counts.negative += 1,
                Class::Zero => counts.zero += 1,
                Class::Nonconvex => counts.nonconvex += 1,
            }
        }
        counts
    }
}

impl APatchReport {
    /// What the function itself tells.
    pub fn new(function: &APatchFunction) -> Self {
        let hull = function.hull();
        let mut problems = BTreeMap::new();
        for problem in hull.problems() {
            *problems.entry(problem.reason().name().to_owned()).or_default() += 1;
        }
        let creases = function.crease_counts();
        let sides = function.free().iter().zip(function.default_free()).zip(function.sufficient_free());
        let raised = sides.flat_map(|((free, default), bound)| {
            Side::BOTH.map(Side::index).map(|s| default[s] < bound[s] && free[s] > default[s])
        });
        Self {
            faces: ClassCounts::new(hull.faces().iter().map(|face| face.class)),
            edges: ClassCounts::new(hull.edges().iter().map(|edge| edge.class)),
            face_cells: hull.faces().iter().map(|face| face.apexes.iter().flatten().count()).sum(),
            edge_cells: hull.edges().iter().map(|edge| edge.cells.iter().flatten().count()).sum(),
            vertices_refined: hull.refined_vertices().len(),
            faces_added: hull.added_faces(),
            vertices_rounded: hull.rounded_vertices().len(),
            rounded_distance: hull.rounded_distance(),
            normals_moved: hull.moved_normals().len(),
            creases_straight: creases.straight,
            creases_curved: creases.curved,
            creases_added: hull.added_creases().len(),
            corners: hull.corners().len(),
            free_raised: raised.filter(|raised| *raised).count(),
            problems,
            ..Self::default()
        }
    }

    /// What a function over polygons tells.
    pub fn of_hybrid(function: &HybridFunction) -> Self {
        let hull = function.hull();
        let of = |element: Option<Element>| hull.faces.iter().filter(|f| f.element == element).count();
        let elements = ElementCounts {
            flat: of(None),
            triangles: of(Some(Element::Triangle)),
            pyramids: of(Some(Element::Pyramid)),
            fans: of(Some(Element::Fan)),
            sectors: of(Some(Element::Sectors)),
            cut: 0,
            measured: 0,
        };
        let [face_cells, edge_cells] = function.cell_counts();
        let creases = function.crease_counts();
        Self {
            faces: ClassCounts::new(hull.faces.iter().map(|face| face.class)),
            edges: ClassCounts::new(hull.edges.iter().map(|edge| edge.class)),
            elements: Some(elements),
            creases_straight: creases.straight,
            creases_curved: creases.curved,
            face_cells,
            edge_cells,
            ..Self::default()
        }
    }

    /// The same with what an inspection found.
    pub fn inspected(mut self, found: &APatchInspection) -> Self {
        let first = |patches: &[PatchId]| patches.iter().take(NAMED_PATCHES).map(|p| p.0).collect();
        (self.undefined, self.undefined_at) = (Some(found.undefined.len()), first(&found.undefined));
        (self.steep, self.steep_at) = (Some(found.steep.len()), first(&found.steep));
        (self.folded, self.folded_at) = (Some(found.folded.len()), first(&found.folded));
        self.self_intersections_of_input = found.input_intersections;
        self
    }
}

/// Patches that are listed of each kind; the rest is only counted.
const NAMED_PATCHES: usize = 10;

impl BaseReport {
    /// The counts of an inspection; a base mesh without singularities.
    pub fn new(inspection: &Inspection) -> Self {
        let t = inspection.topology;
        Self {
            vertices: t.vertices,
            edges: t.edges,
            faces: t.faces,
            components: t.components,
            euler: t.euler,
            genus: t.genus,
            boundary_loops: t.boundary_loops,
            singular_points: 0,
            singular_curves: 0,
        }
    }
}

impl SurfaceReport {
    /// The figures of an inspection; nothing certified. `continuity` is the weakest that a seam claims.
    pub fn new(inspection: &Inspection, kind: &str, continuity: Continuity) -> Self {
        let deviation = inspection.deviation.as_ref();
        let at_vertices = inspection.interpolation;
        let intersections = inspection.intersections.as_ref();
        let closed = inspection.topology.boundary_loops == 0;
        Self {
            patches: inspection.patches,
            kind: kind.to_string(),
            continuity: format!("{continuity:?}"),
            closed,
            max_gap: inspection.seams.max_gap,
            max_normal_jump_rad: inspection.seams.max_normal_jump,
            self_intersections: intersections.map(|i| i.count),
            self_intersections_at: intersections
                .map_or_else(Vec::new, |i| i.first.iter().map(IntersectionReport::from).collect()),
            max_distance: deviation.map(|d| d.max_distance),
            max_distance_back: inspection.coverage.map(|c| c.max_distance),
            rms_distance: deviation.map(|d| d.rms_distance),
            max_normal_error_rad: deviation.map(|d| d.max_normal_error),
            max_distance_first_order: deviation.map(|d| d.max_first_order),
            rms_distance_first_order: deviation.map(|d| d.rms_first_order),
            max_vertex_error: at_vertices.max_position_error,
            max_vertex_normal_error_rad: at_vertices.max_normal_error,
            max_vertex_curvature_error: at_vertices.max_curvature_error,
            area: inspection.extent.area,
            volume: closed.then_some(inspection.extent.volume),
            certified: Certified::default(),
        }
    }
}

impl Report {
    /// The JSON object, indented, with a line feed at the end.
    pub fn to_json(&self) -> Result<String, serde_json::Error> {
        Ok(serde_json::to_string_pretty(self)? + "\n")
    }
}

/// Smallest and largest coordinates of a box, as the report writes them.
pub fn corners(b: &Aabb) -> [[f64; 3]; 2] {
    [b.min.into(), b.max.into()]
}

/// Wall-clock seconds of the stages of a run, in the order in which they ran.
#[derive(Clone, Debug)]
pub struct Seconds {
    start: Instant,
    stages: Vec<(String, f64)>,
}

impl Default for Seconds {
    fn default() -> Self {
        Self { start: Instant::now(), stages: Vec::new() }
    }
}

impl Seconds {
    /// Runs a stage and adds its time; a stage that runs again adds to its first entry.
    pub fn measure<T>(&mut self, stage: &str, run: impl FnOnce() -> T) -> T {
        let start = Instant::now();
        let result = run();
        let seconds = start.elapsed().as_secs_f64();
        match self.stages.iter_mut().find(|(name, _)| name == stage) {
            Some((_, sum)) => *sum += seconds,
            None => self.stages.push((stage.to_string(), seconds)),
        }
        result
    }

    /// Adds the stages of another list at the end.
    pub fn append(&mut self, other: &Self) {
        self.stages.extend(other.stages.iter().cloned());
    }

    /// Seconds since this was made.
    pub fn total(&self) -> f64 {
        self.start.elapsed().as_secs_f64()
    }

    /// Names and seconds of the stages.
    pub fn stages(&self) -> &[(String, f64)] {
        &self.stages
    }
}

impl Serialize for Seconds {
    /// `{ total, and one entry per stage }`.
    fn serialize<S: Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        let mut map = serializer.serialize_map(Some(self.stages.len() + 1))?;
        map.serialize_entry("total", &self.total())?;
        for (stage, seconds) in &self.stages {
            map.serialize_entry(stage, seconds)?;
        }
        map.end()
    }
}

/// Largest resident memory of this process so far, in bytes, as the Linux kernel counts it; none elsewhere.
pub fn peak_memory_bytes() -> Option<u64> {
    peak_of_status(&std::fs::read_to_string("/proc/self/status").ok()?)
}

/// The VmHWM line of a process status, such as `VmHWM:    1234 kB`.
fn peak_of_status(status: &str) -> Option<u64> {
    let line = status.lines().find_map(|l| l.strip_prefix("VmHWM:"))?;
    let kibibytes: u64 = line.trim().strip_suffix("kB")?.trim().parse().ok()?;
    Some(1024 * kibibytes)
}

#[cfg(test)]
mod tests {
    #![allow(
        clippy::unwrap_used,
        clippy::panic,
        reason = "a test that fails by a panic is a test that fails"
    )]

    use super::*;

    fn report() -> Report {
        let mut seconds = Seconds::default();
        seconds.measure("base", || ());
        seconds.measure("spline", || ());
        seconds.measure("base", || ());
        Report {
            schema: SCHEMA,
            input: "x^2+y^2+z^2-1".into(),
            method: Some("spline".into()),
            version: "0.1.0".into(),
            threads: 1,
            unit: "mm".into(),
            negated: false,
            diagonal: 2.0,
            bounds: corners(&Aabb::new([-1.0; 3].into(), [1.0; 3].into())),
            base: BaseReport {
                vertices: 12,
                edges: 30,
                faces: 20,
                components: 1,
                euler: 2,
                genus: 0,
                boundary_loops: 0,
                singular_points: 0,
                singular_curves: 0,
            },
            surface: SurfaceReport {
                patches: 20,
                kind: "bezier-triangle-7".into(),
                continuity: "G1".into(),
                closed: true,
                max_gap: 0.0,
                max_normal_jump_rad: 1e-15,
                self_intersections: Some(1),
                self_intersections_at: vec![IntersectionReport { patches: [3, 7], at: [0.5, 0.0, -1.0] }],
                max_distance: Some(f64::INFINITY),
                max_distance_back: None,
                rms_distance: Some(1e-5),
                max_normal_error_rad: None,
                max_distance_first_order: None,
                rms_distance_first_order: None,
                max_vertex_error: 0.0,
                max_vertex_normal_error_rad: 0.0,
                max_vertex_curvature_error: 0.0,
                area: 12.5,
                volume: Some(4.2),
                certified: Certified::default(),
            },
            spline: Some(SplineReport::default()),
            apatch: Some(APatchReport::default()),
            singular: None,
            rational: Some(RationalReport::default()),
            repairs: vec![Repair { what: "flip".into(), place: "edge 7".into(), why: "sliver".into() }],
            seconds,
            peak_memory_bytes: None,
        }
    }

    /// The words of the schema, in its order; a reader of version 1 relies on every one of them.
    #[test]
    fn json_has_the_fields_of_the_schema_in_order() {
        let text = report().to_json().unwrap();
        let fields = "schema input method version threads unit negated diagonal bounds \
            base vertices edges faces components euler genus boundary_loops singular_points singular_curves \
            surface patches kind continuity closed max_gap max_normal_jump_rad \
            self_intersections self_intersections_at patches at max_distance max_distance_back \
            rms_distance max_normal_error_rad certified distance topology \
            spline sqp_iterations_mean sqp_unconverged curves_at_bound folded faces_over_20deg \
            apatch normals gradient_lengths faces positive negative zero nonconvex edges positive face_cells edge_cells \
            vertices_refined faces_added vertices_rounded rounded_distance \
            normals_moved creases_straight creases_curved creases_added corners free_raised problems undefined undefined_at \
            steep steep_at folded folded_at self_intersections_of_input resolution \
            rational normals sharp_edges crossings singular_vertices folded folded_at \
            repairs what where why seconds total base spline peak_memory_bytes";
        let mut rest = text.as_str();
        for field in fields.split_whitespace() {
            let at = rest.find(&format!("\"{field}\":")).unwrap_or_else(|| panic!("{field} in {text}"));
            rest = &rest[at + field.len()..];
        }
        let json: serde_json::Value = serde_json::from_str(&text).unwrap();
        assert_eq!(json["schema"], 1);
        assert_eq!(json["certified"], serde_json::Value::Null);
        assert_eq!(json["surface"]["certified"], serde_json::json!({"distance": null, "topology": false}));
        assert_eq!(json["surface"]["max_distance"], serde_json::Value::Null);
        assert_eq!(json["seconds"].as_object().unwrap().len(), 3);
    }

    #[test]
    fn peak_memory_is_read_from_the_status_line() {
        assert_eq!(
            peak_of_status("VmPeak:\t  9 kB\nVmHWM:\t    1234 kB\nVmRSS:\t 7 kB\n"),
            Some(1234 * 1024)
        );
        assert_eq!(peak_of_status("nothing here"), None);
        if cfg!(target_os = "linux") {
            assert!(peak_memory_bytes().unwrap() > 100_000);
        }
    }
}
