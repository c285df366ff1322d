//! The spline over a base mesh: curves, patches, vertex systems, edge systems, free points.

use super::edge::{EdgeSolution, EdgeSystem};
use super::fit;
use super::relaxation::relax;
use super::shape::{ShapeError, ShapeParameters};
use super::surface::{DEGREE, NET, TriangularSpline};
use super::vertex::{self, EndWeights, RingCurve, VertexSystem};
use crate::base::BaseMesh;
use crate::bernstein::{curve, index};
use crate::geom::{Point3, Vec3};
use crate::mesh::{EdgeId, FaceId, HalfEdgeId, HalfEdgeMesh, VertexId};
use crate::network::QuarticCurve;
use crate::parallel::Evenly;
use crate::surface::Target;
use rayon::prelude::*;

/// Curves, faces or vertices that one task looks at, where there is little to do for each.
const TASK: usize = 32;

/// How patches are fitted.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct SplineOptions {
    /// What is sampled for the first fit of a patch; default the filled patch.
    pub samples: SampledFrom,
    /// Gauss–Newton steps on the distance along the normal for the three free points of a patch.
    pub normal_distance_steps: usize,
    /// Weight of tangential motion in these steps; much less folds patches.
    pub tangential_weight: f64,
    /// Steps on the distance along the normal in which all points move that no G1 condition binds.
    pub relaxation_steps: usize,
    /// Weight of any motion in these steps. With less, errors fall further in some patches, and grow in others.
    pub relaxation_weight: f64,
}

impl Default for SplineOptions {
    fn default() -> Self {
        Self {
            samples: SampledFrom::Filled,
            normal_distance_steps: 0,
            tangential_weight: 1e-2,
            relaxation_steps: 2,
            relaxation_weight: 3e-4,
        }
    }
}

/// The shape whose samples are projected onto the target, for a patch to fit them.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum SampledFrom {
    /// The patch that fills its boundary with least thin-plate energy.
    Filled,
    /// The flat triangle of its corners, as in (12).
    Flat,
}

/// Why the G1 conditions could not be solved.
#[derive(Clone, Copy, Debug, PartialEq, thiserror::Error)]
pub enum SplineError {
    /// A corner angle at the vertex is 0 or π.
    #[error("the G1 conditions at vertex {vertex} are singular (a corner angle of 0° or 180°)")]
    SingularVertex {
        /// The vertex.
        vertex: u32,
    },
    /// The conditions along the edge are singular: λ is outside (0, 1) at an end.
    #[error("the G1 conditions along edge {edge} between vertices {from} and {to} are singular")]
    SingularEdge {
        /// Edge number.
        edge: u32,
        /// Start vertex.
        from: u32,
        /// End vertex.
        to: u32,
    },
}

/// An edge in one of its two directions: 2e along the edge's half edge, 2e + 1 against it.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
struct Dart(u32);

impl Dart {
    fn new(edge: EdgeId, reversed: bool) -> Self {
        Self(2 * edge.0 + u32::from(reversed))
    }

    /// The dart of a half edge.
    fn of(mesh: &HalfEdgeMesh, h: HalfEdgeId) -> Self {
        let e = mesh.edge(h);
        Self::new(e, mesh.edge_half_edge(e) != h)
    }

    fn index(self) -> usize {
        self.0 as usize
    }

    fn reverse(self) -> Self {
        Self(self.0 ^ 1)
    }

    /// Control point m of its curve, counted from where the dart starts.
    fn point(self, curves: &[[Point3; 5]], m: usize) -> Point3 {
        curves[self.index() / 2][if self.0 & 1 == 0 { m } else { 4 - m }]
    }
}

/// The darts that leave a vertex, counter-clockwise, and the half edge of the corner after each of them (one corner
/// less at a boundary).
struct Ring {
    darts: Vec<Dart>,
    corners: Vec<HalfEdgeId>,
}

/// Edges at a vertex; mostly enough.
const VALENCE: usize = 8;

impl Ring {
    fn of(mesh: &HalfEdgeMesh, v: VertexId) -> Self {
        let mut corners = Vec::with_capacity(VALENCE);
        corners.extend(mesh.ring(v));
        let mut darts = Vec::with_capacity(corners.len() + 1);
        darts.extend(corners.iter().map(|h| Dart::of(mesh, *h)));
        if let (true, Some(last)) = (mesh.is_boundary_vertex(v), corners.last()) {
            darts.push(Dart::of(mesh, mesh.prev(*last)).reverse());
        }
        Self { darts, corners }
    }

    fn is_open(&self) -> bool {
        self.corners.len() < self.darts.len()
    }
}

/// Builds the G1 spline over `base` with the given boundary curves (one an edge), fitted to `target`.
///
/// Tong & Kim 2009, section 6, with the deviations that PAPERS.md lists. Linear time; parallel, with the same
/// result for every number of threads.
pub fn build(
    base: BaseMesh,
    curves: &[QuarticCurve],
    target: &dyn Target,
    options: &SplineOptions,
) -> Result<TriangularSpline, SplineError> {
    assemble(base, curves, target, options, &[], &ShapeParameters::default())
}

/// As [`build`], with values of the caller for what the G1 conditions leave free.
///
/// # Errors
/// Also if values for μ1 can't be had together, which names the vertex, or if a value is not a number.
pub fn build_shaped(
    base: BaseMesh,
    curves: &[QuarticCurve],
    target: &dyn Target,
    options: &SplineOptions,
    shape: &ShapeParameters,
) -> Result<TriangularSpline, ShapeError> {
    shape.check(&base.mesh)?;
    Ok(assemble(base, curves, target, options, &[], shape)?)
}

/// As [`build`], but an edge inside for which `kept` has inner rows gets these, and they do not relax: those of an earlier
/// build with the same curves around both ends of the edge. `kept` has an entry for every edge, or none at all.
pub fn rebuild(
    base: BaseMesh,
    curves: &[QuarticCurve],
    target: &dyn Target,
    options: &SplineOptions,
    kept: &[Option<EdgeSolution>],
) -> Result<TriangularSpline, SplineError> {
    assemble(base, curves, target, options, kept, &ShapeParameters::default())
}

/// More steps of relaxation on a surface that was built with fewer of them over the same target: what [`build`] would have given.
pub fn relaxed(
    mut surface: TriangularSpline,
    target: &dyn Target,
    steps: usize,
    options: &SplineOptions,
) -> TriangularSpline {
    let mesh = &surface.base.mesh;
    let lambdas = edge_lambdas(&end_weights(&surface.base, &surface.curves));
    let fixed = vec![false; mesh.edge_count()];
    for _ in 0..steps {
        relax(mesh, &lambdas, &fixed, &mut surface.nets, target, options.relaxation_weight);
    }
    surface
}

fn assemble(
    base: BaseMesh,
    curves: &[QuarticCurve],
    target: &dyn Target,
    options: &SplineOptions,
    kept: &[Option<EdgeSolution>],
    shape: &ShapeParameters,
) -> Result<TriangularSpline, SplineError> {
    let mut made = Construction::new(base, curves, target, options.samples);
    made.solve_vertices(shape)?;
    made.solve_edges(shape, kept)?;
    made.refit_free_points();
    made.relax(options, kept);
    made.move_inner_points(shape);
    Ok(made.finish())
}

/// A spline in the making: each of section 6's steps once, in this order.
///
/// ```text
/// new ──► solve_vertices ──► solve_edges ──► refit_free_points ──► relax ──► finish
/// G0      6.3, (14)–(19)     6.4, (20)–(25)   6.5                   ours
/// ```
pub struct Construction<'a> {
    base: BaseMesh,
    curves: Vec<[Point3; 5]>,
    target: &'a dyn Target,
    nets: Vec<[Point3; NET]>,
    footprints: Vec<fit::Footprints>,
    weights: Vec<EndWeights>,
    /// μ1 of every dart, once the vertex systems are solved.
    mu1: Vec<f64>,
}

impl<'a> Construction<'a> {
    /// The G0 surface: patches between the curves (one an edge of `base`) that are fitted to the target, each by itself (section
    /// 6.1).
    pub fn new(
        base: BaseMesh,
        curves: &[QuarticCurve],
        target: &'a dyn Target,
        samples: SampledFrom,
    ) -> Self {
        let curves: Vec<[Point3; 5]> = curves.iter().map(|c| c.q).collect();
        let mut nets = nets_with_boundary(&base.mesh, &curves);
        let footprints = fit::fill_and_fit(&mut nets, target, samples);
        let weights = end_weights(&base, &curves);
        Self { base, curves, target, nets, footprints, weights, mu1: Vec::new() }
    }

    /// Twist points that fulfil the rows k = 0, 1 of (3) at both ends of every edge.
    ///
    /// # Errors
    /// A corner angle is 0 or π, or a value for μ1 can't be had.
    pub fn solve_vertices(&mut self, shape: &ShapeParameters) -> Result<(), SplineError> {
        let wanted = wanted_mu1(&self.base.mesh, shape);
        self.mu1 = solve_vertices(&self.base, &self.curves, &self.weights, &wanted, &mut self.nets)?;
        Ok(())
    }

    /// First rows that fulfil the other rows of (3): the surface is G1 after this. For `kept` see [`rebuild`].
    ///
    /// # Errors
    /// λ is outside (0, 1) at an end of an edge.
    pub fn solve_edges(
        &mut self,
        shape: &ShapeParameters,
        kept: &[Option<EdgeSolution>],
    ) -> Result<(), SplineError> {
        // Without the vertex systems, μ is that of straight first rows.
        self.mu1.resize(2 * self.curves.len(), 0.0);
        let nu = shape.nu_of_edges(self.base.mesh.edge_count());
        solve_edges(&self.base.mesh, &self.curves, &self.weights, &self.mu1, &nu, kept, &mut self.nets)
    }

    /// The three points of each patch that no condition binds, fitted again.
    pub fn refit_free_points(&mut self) {
        fit::refit_free_points(&mut self.nets, &self.footprints);
    }

    /// Steps on the distance along the normal in what the conditions leave free, as many as the options say; edges of which `kept` has
    /// rows keep them.
    pub fn relax(&mut self, options: &SplineOptions, kept: &[Option<EdgeSolution>]) {
        // Not needed any more, and as large as the nets.
        self.footprints = Vec::new();
        let mesh = &self.base.mesh;
        let (steps, tangential) = (options.normal_distance_steps, options.tangential_weight);
        fit::reduce_normal_distance(&mut self.nets, self.target, steps, tangential);
        let fixed: Vec<bool> = mesh.edges().map(|e| rows_of(kept, e).is_some()).collect();
        let lambdas = edge_lambdas(&self.weights);
        for _ in 0..options.relaxation_steps {
            relax(mesh, &lambdas, &fixed, &mut self.nets, self.target, options.relaxation_weight);
        }
    }

    /// Moves the points that no condition binds by what the caller wants.
    pub fn move_inner_points(&mut self, shape: &ShapeParameters) {
        shape.move_inner_points(&mut self.nets, fit::FREE_POINTS);
    }

    /// The surface as it is by now.
    pub fn finish(self) -> TriangularSpline {
        TriangularSpline::new(self.base, self.curves, self.nets)
    }
}

/// The value of μ1 that is wanted for every dart; empty if there is none.
fn wanted_mu1(mesh: &HalfEdgeMesh, shape: &ShapeParameters) -> Vec<Option<f64>> {
    let darts = if shape.mu1.is_empty() { 0 } else { 2 * mesh.edge_count() };
    let mut wanted = vec![None; darts];
    shape.mu1.iter().for_each(|(h, mu)| wanted[Dart::of(mesh, *h).index()] = Some(*mu));
    wanted
}

/// Nets whose boundary rows are the curves, elevated from degree 4 to 7 once for both sides; the rest is zero.
pub(super) fn nets_with_boundary(mesh: &HalfEdgeMesh, curves: &[[Point3; 5]]) -> Vec<[Point3; NET]> {
    let elevated: Vec<[Point3; DEGREE + 1]> = curves.par_iter().evenly_by(TASK).map(curve::elevate).collect();
    let faces: Vec<FaceId> = mesh.faces().collect();
    (faces.into_par_iter().evenly_by(TASK))
        .map(|f| {
            let mut net = [Point3::zeros(); NET];
            for (side, h) in mesh.face_half_edges(f).enumerate() {
                let row = &elevated[mesh.edge(h).index()];
                let reversed = mesh.edge_half_edge(mesh.edge(h)) != h;
                for m in 0..=DEGREE {
                    net[index::row(DEGREE, side, 0, m)] = row[if reversed { DEGREE - m } else { m }];
                }
            }
            net
        })
        .collect()
}

/// λ0 and μ0 of every dart, by (15); zero for darts on a boundary.
pub(super) fn end_weights(base: &BaseMesh, curves: &[[Point3; 5]]) -> Vec<EndWeights> {
    let of_vertex = |v: VertexId| {
        let ring = Ring::of(&base.mesh, v);
        let (o, n) = (base.positions[v.index()], base.normals[v.index()]);
        let d: Vec<Vec3> = ring.darts.iter().map(|dart| dart.point(curves, 1) - o).collect();
        let count = d.len();
        let inner = if ring.is_open() { 1..count - 1 } else { 0..count };
        inner.map(move |i| {
            let [before, after] = [(i + count - 1) % count, (i + 1) % count];
            (ring.darts[i], vertex::end_weights(&d[before], &d[i], &d[after], &n))
        })
    };
    let vertices: Vec<VertexId> = base.mesh.vertices().collect();
    let of_vertices = |vertices: &[VertexId]| {
        let mut found = Vec::with_capacity(VALENCE * vertices.len());
        found.extend(vertices.iter().flat_map(|v| of_vertex(*v)));
        found
    };
    let found: Vec<Vec<(Dart, EndWeights)>> = vertices.par_chunks(TASK).evenly().map(of_vertices).collect();
    let mut weights = vec![EndWeights::default(); 2 * curves.len()];
    found.into_iter().flatten().for_each(|(dart, found)| weights[dart.index()] = found);
    weights
}

/// λ(0) and λ(1) of every edge.
fn edge_lambdas(weights: &[EndWeights]) -> Vec<[f64; 2]> {
    // The left side of a dart is the right side of its reverse.
    weights.chunks_exact(2).map(|w| [w[0].lambda, 1.0 - w[1].lambda]).collect()
}

/// Position in the net of the twist point of a half edge's corner, b_511 at its start.
fn twist_position(mesh: &HalfEdgeMesh, h: HalfEdgeId) -> usize {
    index::row(DEGREE, mesh.side(h), 1, 1)
}

/// Solves the vertex systems, puts the twist points into the nets, and gives μ1 of every dart; `wanted_mu1` has values for some
/// darts, or is empty.
pub(super) fn solve_vertices(
    base: &BaseMesh,
    curves: &[[Point3; 5]],
    weights: &[EndWeights],
    wanted_mu1: &[Option<f64>],
    nets: &mut [[Point3; NET]],
) -> Result<Vec<f64>, SplineError> {
    let mesh = &base.mesh;
    let vertices: Vec<VertexId> = mesh.vertices().collect();
    let wanted = &*nets;
    let solve = |v: VertexId, solved: &mut SolvedVertices| {
        let ring = Ring::of(mesh, v);
        let o = base.positions[v.index()];
        let ring_curves: Vec<RingCurve> = ring
            .darts
            .iter()
            .map(|dart| RingCurve { d: dart.point(curves, 1) - o, e: dart.point(curves, 2) - o })
            .collect();
        let ring_weights: Vec<EndWeights> = ring.darts.iter().map(|dart| weights[dart.index()]).collect();
        // The left side of a dart is the right side of its reverse.
        let far: Vec<f64> = ring.darts.iter().map(|d| 1.0 - weights[d.reverse().index()].lambda).collect();
        let twists: Vec<Vec3> = ring
            .corners
            .iter()
            .map(|h| wanted[mesh.face(*h).index()][twist_position(mesh, *h)] - o)
            .collect();
        let system = VertexSystem {
            normal: base.normals[v.index()],
            curvature: base.curvatures[v.index()],
            curves: &ring_curves,
            weights: &ring_weights,
            far_lambda: &far,
            twists: &twists,
        };
        let mu1: Vec<Option<f64>> = match wanted_mu1.is_empty() {
            true => Vec::new(),
            false => ring.darts.iter().map(|dart| wanted_mu1[dart.index()]).collect(),
        };
        let solution =
            vertex::solve_with(&system, &mu1).ok_or(SplineError::SingularVertex { vertex: v.0 })?;
        solved.twists.extend(ring.corners.iter().zip(&solution.twists).map(|(h, t)| (*h, o + t)));
        solved.mu1.extend(ring.darts.iter().zip(&solution.mu1).map(|(dart, mu)| (*dart, *mu)));
        Ok(())
    };
    let solved = vertices.par_chunks(TASK).evenly().map(|vertices| {
        let mut solved = SolvedVertices::with_room(vertices.len());
        vertices.iter().try_for_each(|v| solve(*v, &mut solved)).map(|()| solved)
    });
    let solved: Vec<Result<SolvedVertices, SplineError>> = solved.collect();
    let mut mu1 = vec![0.0; 2 * curves.len()];
    for vertices in solved {
        let vertices = vertices?;
        for (h, point) in vertices.twists {
            nets[mesh.face(h).index()][twist_position(mesh, h)] = point;
        }
        vertices.mu1.into_iter().for_each(|(dart, mu)| mu1[dart.index()] = mu);
    }
    Ok(mu1)
}

/// What the systems of some vertices give: together, so that one thread frees little of what others have allocated.
struct SolvedVertices {
    twists: Vec<(HalfEdgeId, Point3)>,
    mu1: Vec<(Dart, f64)>,
}

impl SolvedVertices {
    fn with_room(vertices: usize) -> Self {
        Self { twists: Vec::with_capacity(VALENCE * vertices), mu1: Vec::with_capacity(VALENCE * vertices) }
    }
}

fn rows_of(kept: &[Option<EdgeSolution>], e: EdgeId) -> Option<EdgeSolution> {
    kept.get(e.index()).copied().flatten()
}

/// Solves the edge systems and puts the inner points of the first rows into the nets; `nu` has ν for every edge, or is empty.
pub(super) fn solve_edges(
    mesh: &HalfEdgeMesh,
    curves: &[[Point3; 5]],
    weights: &[EndWeights],
    mu1: &[f64],
    nu: &[f64],
    kept: &[Option<EdgeSolution>],
    nets: &mut [[Point3; NET]],
) -> Result<(), SplineError> {
    let inner: Vec<(EdgeId, HalfEdgeId, HalfEdgeId)> = mesh
        .edges()
        .filter_map(|e| {
            let h = mesh.edge_half_edge(e);
            mesh.twin(h).map(|g| (e, h, g))
        })
        .collect();
    // Point m of the first row of the patch left of a half edge.
    let place = |h: HalfEdgeId, m: usize| (mesh.face(h).index(), index::row(DEGREE, mesh.side(h), 1, m));
    let wanted = &*nets;
    let solutions: Result<Vec<_>, SplineError> = inner
        .par_iter()
        .evenly()
        .map(|&(e, h, g)| {
            if let Some(rows) = rows_of(kept, e) {
                return Ok(rows);
            }
            let row = |h: HalfEdgeId, m: usize| {
                let (face, position) = place(h, m);
                wanted[face][position]
            };
            let (there, back) = (Dart::new(e, false), Dart::new(e, true));
            let (a, b) = (weights[there.index()], weights[back.index()]);
            let system = EdgeSystem {
                q: curves[e.index()],
                p: std::array::from_fn(|m| row(g, DEGREE - 1 - m)),
                r: std::array::from_fn(|m| row(h, m)),
                lambda: [a.lambda, 1.0 - b.lambda],
                mu: [a.mu, mu1[there.index()], 1.0 - mu1[back.index()], 1.0 - b.mu],
                nu: nu.get(e.index()).copied().unwrap_or(0.0),
            };
            system.solve().ok_or(SplineError::SingularEdge {
                edge: e.0,
                from: mesh.origin(h).0,
                to: mesh.dest(h).0,
            })
        })
        .collect();
    for (&(_, h, g), solution) in inner.iter().zip(&solutions?) {
        for m in 0..3 {
            let (face, position) = place(h, m + 2);
            nets[face][position] = solution.r[m];
            let (face, position) = place(g, DEGREE - 1 - (m + 2));
            nets[face][position] = solution.p[m];
        }
    }
    Ok(())
}
