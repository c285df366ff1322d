use super::GridOut;
use crate::apatch::build::APatchFunction;
use crate::apatch::edge::{EdgeFunction, Rim};
use crate::apatch::lanes::{self, LANES, Lane, Rays, Vectors, pick, product, quadratic, to_gradient};
use crate::geom::Point3;
use crate::hull::{Class, Side};
use crate::mesh::EdgeId;

/// Parameters of points over an edge: weights of its start and its end, and of the apex on the left.
#[derive(Clone, Debug)]
pub struct EdgeTable {
    points: Vec<[f64; 3]>,
    vectors: Vectors,
    chunks: Vec<[Lane; 3]>,
}

impl EdgeTable {
    /// For points with the given weights (x, z, y): x + z = 1 along the edge, y at the apex of the left face.
    pub fn new(points: &[[f64; 3]]) -> Self {
        let chunk = |points: &[[f64; 3]]| std::array::from_fn(|c| Lane::new(points, |x| x[c]));
        Self {
            points: points.to_vec(),
            vectors: Vectors::default(),
            chunks: points.chunks(LANES).map(chunk).collect(),
        }
    }

    /// To be computed in the given vectors; the widest are the default.
    pub fn with_vectors(self, vectors: Vectors) -> Self {
        Self { vectors, ..self }
    }

    /// Number of points.
    pub fn len(&self) -> usize {
        self.points.len()
    }

    /// No points?
    pub fn is_empty(&self) -> bool {
        self.points.is_empty()
    }

    /// Points of the patch over an edge that has a cell, and normals; NaN where a ray has no root.
    ///
    /// # Panics
    /// If the slices of `out` are shorter than the table.
    pub fn evaluate(&self, function: &APatchFunction, e: EdgeId, out: &mut GridOut<'_>) {
        if !self.evaluate_cells(&EdgeCells::of(function, e), out) {
            out.complete(self.len(), |i| {
                let [x, z, y] = self.points[i];
                function.shoot_edge(e, [x, z], y)
            });
        }
    }

    /// The same over an edge that is given by its cells. Points that take more than the lanes do are left NaN; says whether there
    /// are none.
    ///
    /// # Panics
    /// If the slices of `out` are shorter than the table.
    pub fn evaluate_cells(&self, cells: &EdgeCells, out: &mut GridOut<'_>) -> bool {
        lanes::shoot(
            self.vectors,
            &EdgePatch::new(cells, out.normals.is_some()),
            &self.chunks,
            self.len(),
            out,
        )
    }
}

/// The cells of an edge with the function in them.
#[derive(Clone, Debug)]
pub struct EdgeCells {
    /// How the surface bends over the edge.
    pub class: Class,
    /// Its start and its end.
    pub ends: [Point3; 2],
    /// On the outer and the inner side, the apexes of the right and the left face, and the function.
    pub sides: [Option<([Point3; 2], EdgeFunction)>; 2],
}

impl EdgeCells {
    fn of(function: &APatchFunction, e: EdgeId) -> Self {
        let hull = function.hull();
        let (mesh, h) = (hull.data().mesh(), hull.data().mesh().edge_half_edge(e));
        let of_side = |side| {
            let [u_l, _, _, u_k] = function.edge_cell(e, side)?;
            Some(([u_l, u_k], function.edge_function(e, side)?))
        };
        // Each made where it is to stand: a map over the sides would move them.
        let sides = [of_side(Side::Outer), of_side(Side::Inner)];
        let ends = [mesh.origin(h), mesh.dest(h)].map(|v| hull.data().positions()[v.index()]);
        Self { class: hull.edges()[e.index()].class, ends, sides }
    }
}

/// A [`Rim`]: layer 1, its middle twice, layer 2 at both ends, and layer 3.
struct RimRow {
    layer1: [f64; 3],
    layer2: [f64; 2],
    b: [f64; 1],
}

impl RimRow {
    fn new(rim: &Rim) -> Self {
        let [f_i, f_ij, f_j] = rim.layer1;
        Self {
            layer1: [f_i, 2.0 * f_ij, f_j],
            layer2: [rim.layer2(1.0, 0.0), rim.layer2(0.0, 1.0)],
            b: [rim.b],
        }
    }

    #[inline(always)]
    fn pick(first: bool, a: &Self, b: &Self) -> Self {
        Self {
            layer1: pick(first, &a.layer1, &b.layer1),
            layer2: pick(first, &a.layer2, &b.layer2),
            b: pick(first, &a.b, &b.b),
        }
    }

    #[inline(always)]
    fn layer1(&self, x: f64, z: f64) -> f64 {
        self.layer1[0] * (x * x) + self.layer1[2] * (z * z) + self.layer1[1] * (x * z)
    }

    /// Half the derivatives of layer 1 by x and z.
    #[inline(always)]
    fn layer1_d(&self, x: f64, z: f64) -> [f64; 2] {
        let [f_i, f_2ij, f_j] = self.layer1;
        let half = 0.5 * f_2ij;
        [f_i * x + half * z, half * x + f_j * z]
    }
}

/// What the rays of one side need.
struct EdgeRay {
    sign: [f64; 1],
    /// Apexes of the right and the left face.
    apexes: [[f64; 3]; 2],
    left: RimRow,
    right: RimRow,
    b: [f64; 2],
    a: [f64; 2],
    far: [f64; 2],
    to_gradient: [f64; 12],
}

/// The parts of layers 1 to 3 that go with powers of the weights of the right and the left apex.
struct EdgeLayers {
    first: [f64; 2],
    second: [f64; 3],
    third: [f64; 2],
}

impl EdgeRay {
    #[inline(always)]
    fn layers(&self, x: f64, z: f64, y: f64) -> EdgeLayers {
        let (left, right, w) = (&self.left, &self.right, 1.0 - y);
        let [f_1002, f_2001] = self.far;
        let mean = y * along(&self.b, x, z) + w * along(&self.a, x, z);
        EdgeLayers {
            first: [right.layer1(x, z), left.layer1(x, z)],
            second: [along(&right.layer2, x, z), mean, along(&left.layer2, x, z)],
            third: [
                quadratic(w, y, [right.b[0], f_2001, f_1002]),
                quadratic(w, y, [f_2001, f_1002, left.b[0]]),
            ],
        }
    }
}

/// An edge with all that its points need.
struct EdgePatch {
    class: Class,
    /// Start and end.
    ends: [[f64; 3]; 2],
    /// Coefficients of layer 0.
    e: [f64; 2],
    sides: [Option<EdgeRay>; 2],
}

/// A linear function along the edge, by its values at the ends.
#[inline(always)]
fn along(c: &[f64; 2], x: f64, z: f64) -> f64 {
    c[0] * x + c[1] * z
}

impl EdgePatch {
    fn new(edge: &EdgeCells, normals: bool) -> Self {
        let [p_i, p_j] = edge.ends;
        let mut layer0 = [0.0; 2];
        let mut of_side = |side: Side| {
            let ([u_l, u_k], cell) = edge.sides[side.index()].as_ref()?;
            layer0 = cell.e.map(|e| side.sign() * e);
            Some(EdgeRay {
                sign: [side.sign()],
                apexes: [(*u_l).into(), (*u_k).into()],
                left: RimRow::new(&cell.left),
                right: RimRow::new(&cell.right),
                b: cell.b,
                a: cell.a,
                far: cell.far,
                to_gradient: if normals { to_gradient(side, &[*u_l, p_i, p_j, *u_k]) } else { [0.0; 12] },
            })
        };
        let sides = [of_side(Side::Outer), of_side(Side::Inner)];
        Self { class: edge.class, ends: edge.ends.map(Into::into), e: layer0, sides }
    }
}

impl EdgePatch {
    /// The derivative at the root t by the weight of the start (0) or the end (1) of the edge.
    #[inline(always)]
    fn derivative<const V: usize>(&self, side: &EdgeRay, [x, z, y]: [f64; 3], t: f64) -> f64 {
        let (r, w, at) = (1.0 - t, 1.0 - y, [x, z]);
        // The derivative of layer 0 by x is 3 z (2 e_0 x + e_1 z), by z it is 3 x (e_0 x + 2 e_1 z).
        let base = at[1 - V] * (2.0 * self.e[V] * at[V] + self.e[1 - V] * at[1 - V]);
        let first = y * side.left.layer1_d(x, z)[V] + w * side.right.layer1_d(x, z)[V];
        let mean = y * side.b[V] + w * side.a[V];
        let second = quadratic(w, y, [side.right.layer2[V], mean, side.left.layer2[V]]);
        3.0 * quadratic(r, t, [side.sign[0] * base, first, second])
    }
}

impl Rays for EdgePatch {
    type Chunk = [Lane; 3];
    type Side = EdgeRay;

    fn class(&self) -> Class {
        self.class
    }

    fn sides(&self) -> &[Option<EdgeRay>; 2] {
        &self.sides
    }

    #[inline(always)]
    fn pick(first: bool, a: &EdgeRay, b: &EdgeRay) -> EdgeRay {
        let [[a_l, a_k], [b_l, b_k]] = [&a.apexes, &b.apexes];
        EdgeRay {
            sign: pick(first, &a.sign, &b.sign),
            apexes: [pick(first, a_l, b_l), pick(first, a_k, b_k)],
            left: RimRow::pick(first, &a.left, &b.left),
            right: RimRow::pick(first, &a.right, &b.right),
            b: pick(first, &a.b, &b.b),
            a: pick(first, &a.a, &b.a),
            far: pick(first, &a.far, &b.far),
            to_gradient: pick(first, &a.to_gradient, &b.to_gradient),
        }
    }

    #[inline(always)]
    fn base(&self, chunk: &[Lane; 3], i: usize) -> f64 {
        let (x, z) = (chunk[0].0[i], chunk[1].0[i]);
        3.0 * (x * z) * along(&self.e, x, z)
    }

    #[inline(always)]
    fn layers(&self, side: &EdgeRay, chunk: &[Lane; 3], base: f64, i: usize) -> [f64; 4] {
        let [x, z, y] = [chunk[0].0[i], chunk[1].0[i], chunk[2].0[i]];
        let w = 1.0 - y;
        let EdgeLayers { first: [right, left], second, third } = side.layers(x, z, y);
        [side.sign[0] * base, y * left + w * right, quadratic(w, y, second), w * third[0] + y * third[1]]
    }

    #[inline(always)]
    fn point(&self, side: &EdgeRay, chunk: &[Lane; 3], t: f64, i: usize) -> [f64; 3] {
        let [x, z, y] = [chunk[0].0[i], chunk[1].0[i], chunk[2].0[i]];
        let ([p_i, p_j], [u_l, u_k], w) = (&self.ends, &side.apexes, 1.0 - y);
        let mut point = [0.0; 3];
        for c in 0..3 {
            let (on_edge, top) = (x * p_i[c] + z * p_j[c], y * u_k[c] + w * u_l[c]);
            point[c] = on_edge + t * (top - on_edge);
        }
        point
    }

    #[inline(always)]
    fn gradient(&self, side: &EdgeRay, chunk: &[Lane; 3], t: f64, i: usize) -> [f64; 3] {
        let [x, z, y] = [chunk[0].0[i], chunk[1].0[i], chunk[2].0[i]];
        let (r, w) = (1.0 - t, 1.0 - y);
        let EdgeLayers { first: [right1, left1], second: [right2, mean, left2], third } =
            side.layers(x, z, y);
        let (b, a) = (along(&side.b, x, z), along(&side.a, x, z));
        let to_right = w * right2 + y * (mean + w * (a - mean));
        let to_left = y * left2 + w * (mean + y * (b - mean));
        let by_right = 3.0 * quadratic(r, t, [right1, to_right, third[0]]);
        let by_left = 3.0 * quadratic(r, t, [left1, to_left, third[1]]);
        let by_start = self.derivative::<0>(side, [x, z, y], t);
        let by_end = self.derivative::<1>(side, [x, z, y], t);
        product(&side.to_gradient, [by_right, by_start, by_end, by_left])
    }
}
