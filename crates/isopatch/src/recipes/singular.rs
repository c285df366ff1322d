//! An algebraic surface with singularities as triangles that conform to them: Bajaj & Xu 1997, sections 3 and 4.
//!
//! ```text
//! box ──► singular set ──► conforming triangulation ──► flat triangles with the normals of their sheets
//! ```

use std::collections::{BTreeMap, HashMap};

use super::spline::Size;
use crate::base::{self, BaseError, Repair};
use crate::expand::{Check, ExpandError, ExpandOptions};
use crate::field::{Field, Formula};
use crate::geom::{Aabb, Point3, Vec3, angle_between};
use crate::io::ThinParts;
use crate::report::{BaseReport, Certified, Seconds, SingularReport, SurfaceReport};
use crate::singular::mesh::{
    EdgeTag, LowerPart, SingularMesh, TriangulateError, TriangulateOptions, Triangulated, sheets,
    triangulate, triangulate_by_expansion,
};
use crate::singular::{
    SingularError, SingularOptions, SingularSet, components, singular_set, without_repeated_factors,
};
use crate::surface::{Continuity, PatchId};
use crate::tessellate::Tessellation;

/// What the recipe is given besides the formula.
#[derive(Clone, Debug, Default)]
pub struct SingularRecipe {
    /// Where the surface is; found if the surface is bounded and none is given.
    pub bounds: Option<Aabb>,
    /// Number of triangles, or the largest distance.
    pub size: Size,
    /// The search for singularities.
    pub search: SingularOptions,
    /// The mesh; its tolerance and number of triangles follow from `size` unless that is automatic.
    pub mesh: TriangulateOptions,
    /// Expand the surface by Algorithm 1 or 2 of the paper instead; `size` counts only as a tolerance then, for ε.
    pub expand: Option<ExpandOptions>,
}

/// What became of a formula.
#[derive(Clone, Debug)]
pub struct FittedSingular {
    /// Where the surface was looked for.
    pub bounds: Aabb,
    /// The singular set there.
    pub set: SingularSet,
    /// The mesh.
    pub triangulated: Triangulated,
    /// What the check of an expansion says; none of the conforming triangulation, which needs none.
    pub check: Option<Check>,
    /// Measured on it.
    pub measured: Measured,
    /// Time of each stage.
    pub seconds: Seconds,
}

/// What is measured on a conforming mesh. Lengths are relative to the diagonal of its vertices.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Measured {
    /// That diagonal, a length.
    pub diagonal: f64,
    /// Largest |f| / |∇f| on the triangles, gradients below [`TriangulateOptions::gradient_floor`] counting as that.
    pub distance: f64,
    /// Its root mean square by area.
    pub rms_distance: f64,
    /// Largest angle between two triangles at a smooth edge, in radians.
    pub turn: f64,
    /// Area, in squared model units.
    pub area: f64,
    /// Triangles at more than a right angle to the surface at a corner.
    pub folded: usize,
}

/// Why there is no mesh.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
pub enum SingularRecipeError {
    /// No box.
    #[error(transparent)]
    Box(#[from] BaseError),
    /// The singular set is not found.
    #[error(transparent)]
    Search(#[from] SingularError),
    /// No conforming mesh.
    #[error(transparent)]
    Mesh(#[from] TriangulateError),
    /// No expansion.
    #[error(transparent)]
    Expand(#[from] ExpandError),
    /// Not a polynomial with rational coefficients.
    #[error("the power series of an expansion need a polynomial with rational coefficients")]
    NotAPolynomial,
    /// Nothing of dimension 2.
    #[error(
        "no surface in the box, only {points} isolated point{} and {curves} curve{} without sheets: isopatch singular lists them",
        if *.points == 1 { "" } else { "s" },
        if *.curves == 1 { "" } else { "s" }
    )]
    NoSheets {
        /// Isolated points.
        points: usize,
        /// Curves.
        curves: usize,
    },
    /// Not even that.
    #[error("no surface in the box")]
    Empty,
}

/// With a number of triangles, this share of the diagonal of the box is far enough for any use.
const LOOSE: f64 = 0.05;

/// Times that a mesh is made for a tolerance.
const ATTEMPTS: usize = 4;
/// Margin of the next one.
const SAFETY: f64 = 0.95;

/// The singular set of a formula in a box.
pub fn find(formula: &Formula, recipe: &SingularRecipe) -> Result<(Aabb, SingularSet), SingularRecipeError> {
    let bounds = recipe.bounds.map_or_else(|| base::find_box(formula), Ok)?;
    Ok((bounds, singular_set(formula, &bounds, &recipe.search)?))
}

/// The conforming mesh of the zero set of `formula`; `progress` is told the name of each stage as it starts.
pub fn fit(
    formula: &Formula,
    recipe: &SingularRecipe,
    progress: &dyn Fn(&str),
) -> Result<FittedSingular, SingularRecipeError> {
    let mut seconds = Seconds::default();
    progress("singular set");
    let (bounds, set) = seconds.measure("singular set", || find(formula, recipe))?;
    fit_with(formula, bounds, set, recipe, seconds, progress)
}

/// The same for a singular set that is known.
pub fn fit_with(
    formula: &Formula,
    bounds: Aabb,
    set: SingularSet,
    recipe: &SingularRecipe,
    mut seconds: Seconds,
    progress: &dyn Fn(&str),
) -> Result<FittedSingular, SingularRecipeError> {
    // Without sign changes there is nothing to triangulate.
    let reduced = without_repeated_factors(formula)?;
    let formula = reduced.as_ref().unwrap_or(formula);
    if let Some(options) = &recipe.expand {
        return expanded(formula, bounds, set, recipe, options, seconds, progress);
    }
    let degree = formula.quadratic_polynomial().map_or(0, |p| p.degree());
    let mut attempts = ATTEMPTS;
    let mut options = match recipe.size {
        Size::Automatic => recipe.mesh.clone(),
        Size::Faces(n) => TriangulateOptions { triangles: Some(n), tolerance: LOOSE, ..recipe.mesh.clone() },
        Size::Tolerance(tolerance) => TriangulateOptions { tolerance, ..recipe.mesh.clone() },
    };
    let (triangulated, measured) = loop {
        progress("triangulation");
        let triangulated =
            seconds.measure("triangulation", || triangulate(formula, degree, &set, &bounds, &options))?;
        progress("inspection");
        let measured = seconds
            .measure("inspection", || measure(formula, &triangulated.mesh, triangulated.gradient_floor));
        attempts -= 1;
        match recipe.size {
            // The diagonal is that of the mesh, which may be smaller than that of the box.
            Size::Tolerance(asked) if measured.distance > asked && attempts > 0 => {
                options.tolerance *= SAFETY * asked / measured.distance;
            }
            _ => break (triangulated, measured),
        }
    };
    if triangulated.mesh.triangles.is_empty() {
        let points = triangulated.mesh.lower.iter().filter(|p| matches!(p, LowerPart::Point(_))).count();
        let curves = triangulated.mesh.lower.len() - points;
        return Err(match points + curves {
            0 => SingularRecipeError::Empty,
            _ => SingularRecipeError::NoSheets { points, curves },
        });
    }
    Ok(FittedSingular { bounds, set, triangulated, check: None, measured, seconds })
}

/// The triangles of Algorithm 1 or 2, from a seed on every component.
fn expanded(
    formula: &Formula,
    bounds: Aabb,
    set: SingularSet,
    recipe: &SingularRecipe,
    options: &ExpandOptions,
    mut seconds: Seconds,
    progress: &dyn Fn(&str),
) -> Result<FittedSingular, SingularRecipeError> {
    let polynomial = formula.polynomial().ok_or(SingularRecipeError::NotAPolynomial)?;
    progress("seeds");
    let found = seconds.measure("seeds", || components(formula, &bounds, &set, &recipe.search))?;
    let seeds = found.map_or_else(Vec::new, |c| c.seeds);
    let options = match recipe.size {
        Size::Tolerance(epsilon) => ExpandOptions { epsilon, ..*options },
        Size::Automatic | Size::Faces(_) => *options,
    };
    progress("triangulation");
    let (triangulated, check) = seconds.measure("triangulation", || {
        triangulate_by_expansion(formula, polynomial, &set, &bounds, &seeds, &options)
    })?;
    progress("inspection");
    let measured =
        seconds.measure("inspection", || measure(formula, &triangulated.mesh, triangulated.gradient_floor));
    Ok(FittedSingular { bounds, set, triangulated, check: Some(check), measured, seconds })
}

/// Intervals along the edges of triangles for the points at which they are compared with the surface.
const INTERVALS: usize = 8;

fn measure(field: &dyn Field, mesh: &SingularMesh, floor: f64) -> Measured {
    let diagonal = Aabb::around(&mesh.positions).diagonal();
    let corners = |t: &[u32; 3]| t.map(|v| mesh.positions[v as usize]);
    let flat = |t: &[u32; 3]| {
        let [p, q, r] = corners(t);
        (q - p).cross(&(r - p))
    };
    let n = INTERVALS;
    let weights: Vec<[f64; 3]> = (0..=n)
        .flat_map(|i| (0..=n - i).map(move |j| [i, j, n - i - j].map(|k| k as f64 / n as f64)))
        .collect();
    let mut found = Measured { diagonal, ..Measured::default() };
    let mut squares = 0.0;
    for (t, normals) in mesh.triangles.iter().zip(&mesh.normals) {
        let ([p, q, r], normal) = (corners(t), flat(t));
        let area = 0.5 * normal.norm();
        let mut sum = 0.0;
        for [a, b, c] in &weights {
            let (f, gradient) = field.gradient(p * *a + q * *b + r * *c);
            let distance = f.abs() / gradient.norm().max(floor) / diagonal;
            found.distance = found.distance.max(distance);
            sum += distance * distance;
        }
        found.area += area;
        squares += area * sum / weights.len() as f64;
        found.folded += usize::from(normals.iter().any(|n| n.dot(&normal) < 0.0));
    }
    found.rms_distance = (squares / found.area).sqrt();
    for (ends, around) in mesh.edges() {
        if let [a, b] = around[..]
            && mesh.tag(ends, 2) == EdgeTag::Smooth
        {
            let [a, b] = [a, b].map(|t| flat(&mesh.triangles[t as usize]));
            found.turn = found.turn.max(angle_between(&a, &b));
        }
    }
    found
}

impl FittedSingular {
    /// The triangles with the normals of their sheets, for writers.
    pub fn tessellation(&self) -> Tessellation {
        let mesh = &self.triangulated.mesh;
        let mut normals: Vec<Option<Vec3>> = vec![None; mesh.positions.len()];
        let mut more: Vec<Vec3> = Vec::new();
        let mut known: HashMap<(u32, [u64; 3]), u32> = HashMap::new();
        let mut corner_normals = Vec::with_capacity(mesh.triangles.len());
        for (t, of_corners) in mesh.triangles.iter().zip(&mesh.normals) {
            corner_normals.push([0, 1, 2].map(|k| {
                let (v, n) = (t[k], of_corners[k]);
                let bits = [n.x, n.y, n.z].map(f64::to_bits);
                *known.entry((v, bits)).or_insert_with(|| match &mut normals[v as usize] {
                    first @ None => {
                        *first = Some(n);
                        v
                    }
                    Some(_) => {
                        more.push(n);
                        (mesh.positions.len() + more.len() - 1) as u32
                    }
                })
            }));
        }
        Tessellation {
            positions: mesh.positions.clone(),
            normals: normals.into_iter().map(|n| n.unwrap_or_else(Vec3::z)).chain(more).collect(),
            triangles: mesh.triangles.clone(),
            corner_normals,
            patches: (0..mesh.triangles.len() as u32).map(PatchId).collect(),
        }
    }

    /// Isolated points and sticks, for writers.
    pub fn thin_parts(&self) -> ThinParts {
        let mut parts = ThinParts::default();
        for part in &self.triangulated.mesh.lower {
            match part {
                LowerPart::Point(p) => parts.points.push(*p),
                LowerPart::Stick(samples) => parts.curves.push(samples.clone()),
            }
        }
        parts
    }

    /// What an expansion could not do; empty for the conforming triangulation.
    pub fn repairs(&self) -> Vec<Repair> {
        let Some(check) = &self.check else { return Vec::new() };
        let faults = [
            (check.gap_edges, "edges at gaps", "the front found no triangle that fits there"),
            (check.bad_edges, "edges with other than two triangles", "sheets were triangulated twice"),
            (
                check.missing_segments,
                "segments of singular curves without sheets",
                "the front did not come there",
            ),
            (
                check.crowded_segments,
                "segments of singular curves with too many triangles",
                "a sheet was triangulated twice there",
            ),
            (check.folded, "triangles that turn over", "steps were too long for the curvature"),
        ];
        let word = |(count, what, why): (usize, &str, &str)| Repair {
            what: format!("{what}: {count}"),
            place: "whole mesh".into(),
            why: format!("{why}; --triangulate conforming has no such faults"),
        };
        faults.into_iter().filter(|(count, ..)| *count > 0).map(word).collect()
    }

    /// The mesh in numbers.
    pub fn base_report(&self) -> BaseReport {
        let mesh = &self.triangulated.mesh;
        let edges = mesh.edges();
        let euler = mesh.euler_number();
        let border: Vec<[u32; 2]> =
            edges.iter().filter(|(_, t)| t.len() == 1).map(|(ends, _)| *ends).collect();
        let components = count_connected(mesh.triangles.iter().map(|t| t.as_slice()));
        let boundary_loops = count_connected(border.iter().map(|e| e.as_slice()));
        let is_manifold = edges.values().all(|t| t.len() <= 2);
        // 2 − 2g − loops = χ, where there is no singular curve.
        let genus = if is_manifold { (2 * components as i64 - boundary_loops as i64 - euler) / 2 } else { 0 };
        let (vertices, edges, faces) = (mesh.positions.len(), edges.len(), mesh.triangles.len());
        let (singular_points, singular_curves) = (self.set.points.len(), self.set.curves.len());
        BaseReport {
            vertices,
            edges,
            faces,
            components,
            euler,
            genus,
            boundary_loops,
            singular_points,
            singular_curves,
        }
    }

    /// The surface in numbers: flat triangles, G0.
    pub fn surface_report(&self) -> SurfaceReport {
        let measured = &self.measured;
        SurfaceReport {
            patches: self.triangulated.mesh.triangles.len(),
            kind: "flat-triangle".to_owned(),
            continuity: format!("{:?}", Continuity::G0),
            closed: self.base_report().boundary_loops == 0,
            max_gap: 0.0,
            max_normal_jump_rad: measured.turn,
            self_intersections: None,
            self_intersections_at: Vec::new(),
            max_distance: None,
            max_distance_back: None,
            rms_distance: None,
            max_normal_error_rad: None,
            max_distance_first_order: Some(measured.distance),
            rms_distance_first_order: Some(measured.rms_distance),
            max_vertex_error: 0.0,
            max_vertex_normal_error_rad: 0.0,
            max_vertex_curvature_error: 0.0,
            area: measured.area,
            volume: None,
            certified: Certified::default(),
        }
    }

    /// What was found of singularities.
    pub fn singular_report(&self) -> SingularReport {
        let mesh = &self.triangulated.mesh;
        let mut edges_by_valence = BTreeMap::new();
        for edge in mesh.features().iter().filter(|edge| edge.tag == EdgeTag::Singular) {
            *edges_by_valence.entry(edge.valence).or_default() += 1;
        }
        let points = mesh.lower.iter().filter(|part| matches!(part, LowerPart::Point(_))).count();
        /// Places that are listed.
        const LISTED: usize = 10;
        let doubtful: &[Point3] = &self.triangulated.doubtful;
        SingularReport {
            points: self.set.points.len(),
            arcs: self.set.curves.len(),
            special: self.set.special.len(),
            lower_dimensional: [points, mesh.lower.len() - points],
            edges_by_valence,
            sheets: sheets(mesh).len(),
            cells: self.triangulated.cells,
            cells_uncertain: self.triangulated.uncertain,
            doubtful_at: doubtful.iter().take(LISTED).map(|p| (*p).into()).collect(),
            folded: self.measured.folded,
        }
    }
}

/// Parts that are connected by common vertices.
fn count_connected<'a>(cells: impl Iterator<Item = &'a [u32]>) -> usize {
    let mut root: BTreeMap<u32, u32> = BTreeMap::new();
    fn find(root: &mut BTreeMap<u32, u32>, v: u32) -> u32 {
        let mut top = v;
        while let Some(next) = root.get(&top).filter(|next| **next != top) {
            top = *next;
        }
        root.insert(v, top);
        top
    }
    for cell in cells {
        for v in cell {
            root.entry(*v).or_insert(*v);
            let (a, b) = (find(&mut root, cell[0]), find(&mut root, *v));
            root.insert(a.max(b), a.min(b));
        }
    }
    root.iter().filter(|(v, top)| v == top).count()
}
