//! The paper's default rule: value and gradient at the apex such that the polynomial part of the function comes nearest to a
//! quadratic, coefficient by coefficient; and to a linear function as well, if that is asked for.
//!
//! The least-squares solution of smallest size is taken: over a planar polygon the equations leave one direction open, so that the
//! rule does not give quadrics back there (docs/theory/hybrid.md).

use super::affine::Affine;
use super::layers::barycentric;
use super::paper_fan;
use crate::geom::{Point3, Vec3};
use crate::hull::Side;
use crate::hybrid::{Element, HybridFace, Jet, PolygonFrame, Quadric};
use nalgebra::{DMatrix, DVector};

/// Coefficients of a quadratic, value and gradient at the apex, coefficients of a linear function.
const QUADRATIC: usize = 10;
const AT_APEX: usize = 4;
const LINEAR: usize = 4;
const UNKNOWNS: usize = QUADRATIC + AT_APEX + LINEAR;

/// Singular values below this, relative to 1, are zero.
const SINGULAR: f64 = 1e-9;

/// Value and gradient at the apex of a triangle, a pyramid or a fan; none for sectors, which the paper does not have.
pub(super) fn at_apex(frame: &PolygonFrame, face: &HybridFace, linear: bool) -> Option<(Side, Jet)> {
    if face.element == Some(Element::Fan) {
        return Some((Side::Inner, paper_fan::at_apex(frame, face)?));
    }
    let side = Side::BOTH.into_iter().find(|side| face.apexes[side.index()].is_some())?;
    let a = face.apexes[side.index()]?;
    let length = frame.p.iter().map(|p| (p - a).norm()).fold(0.0, f64::max);
    let unknowns = Unknowns { a, length, center: face.center };
    let equations = match face.element? {
        Element::Triangle => over_triangle(frame, &unknowns),
        Element::Pyramid => over_pyramid(frame, &unknowns),
        Element::Fan | Element::Sectors => return None,
    };
    let near = |n: usize| equations.iter().map(move |(coefficient, near)| &near[n] + &(-1.0 * coefficient));
    let rows: Vec<Affine> = if linear { near(0).chain(near(1)).collect() } else { near(0).collect() };
    let matrix = DMatrix::from_fn(rows.len(), UNKNOWNS, |i, j| rows[i].slope[j]);
    let wanted = DVector::from_iterator(rows.len(), rows.iter().map(|row| -row.value));
    let x = matrix.svd(true, true).solve(&wanted, SINGULAR).ok()?;
    let gradient = Vec3::new(x[QUADRATIC + 1], x[QUADRATIC + 2], x[QUADRATIC + 3]);
    Some((side, Jet { value: length * x[QUADRATIC], gradient }))
}

/// A coefficient of the function, and the same of the quadratic and of the linear function.
type Equation = (Affine, [Affine; 2]);

struct Unknowns {
    a: Point3,
    length: f64,
    center: Point3,
}

impl Unknowns {
    fn fixed(&self, value: f64) -> Affine {
        Affine::constant(value, UNKNOWNS)
    }

    /// F(a, a, x).
    fn towards(&self, x: &Point3) -> Affine {
        let mut form = self.fixed(0.0);
        let third = (x - self.a) / 3.0;
        form.slope[QUADRATIC] = self.length;
        form.slope.rows_mut(QUADRATIC + 1, 3).copy_from(&third);
        form
    }

    /// The coefficient of three points of the quadratic and of the linear function, both raised to degree 3.
    fn near(&self, x: &Point3, y: &Point3, z: &Point3) -> [Affine; 2] {
        let mut forms = [self.fixed(0.0), self.fixed(0.0)];
        for j in 0..QUADRATIC {
            let mut coefficients = [0.0; QUADRATIC];
            coefficients[j] = self.length;
            let one = Quadric { coefficients, center: self.center, scale: self.length };
            forms[0].slope[j] = one.blossom(x, y, z);
        }
        let mean = ((x + y + z) / 3.0 - self.center) / self.length;
        forms[1].slope[QUADRATIC + AT_APEX] = self.length;
        forms[1].slope.rows_mut(QUADRATIC + AT_APEX + 1, 3).copy_from(&(self.length * mean));
        forms
    }

    fn mean_near(&self, weighted: &[(f64, [&Point3; 3])]) -> [Affine; 2] {
        let mut sums = [self.fixed(0.0), self.fixed(0.0)];
        for (weight, [x, y, z]) in weighted {
            let forms = self.near(x, y, z);
            for (sum, form) in sums.iter_mut().zip(&forms) {
                *sum = &*sum + &(*weight * form);
            }
        }
        sums
    }
}

/// What both kinds of cells have: layers 2 and 3, and what the data give at corners and over edges.
fn common(frame: &PolygonFrame, u: &Unknowns) -> Vec<Equation> {
    let a = &u.a;
    let mut equations = vec![(u.towards(a), u.near(a, a, a))];
    for k in 0..frame.count() {
        let (p, q) = (&frame.p[k], &frame.p[frame.after(k)]);
        let next = frame.after(k);
        equations.push((u.towards(p), u.near(a, a, p)));
        equations.push((u.fixed(frame.at_corner(k, a)), u.near(a, p, p)));
        equations.push((u.fixed(frame.on_edge(k, a)), u.near(a, p, q)));
        equations.push((u.fixed(0.0), u.near(p, p, p)));
        equations.push((u.fixed(frame.at_corner(k, q)), u.near(p, p, q)));
        equations.push((u.fixed(frame.at_corner(next, p)), u.near(q, q, p)));
    }
    equations
}

fn over_triangle(frame: &PolygonFrame, u: &Unknowns) -> Vec<Equation> {
    let mut equations = common(frame, u);
    let middle = (0..3).map(|k| frame.on_edge(k, &frame.p[(k + 2) % 3])).sum::<f64>() / 3.0;
    equations.push((u.fixed(middle), u.near(&frame.p[0], &frame.p[1], &frame.p[2])));
    equations
}

fn over_pyramid(frame: &PolygonFrame, u: &Unknowns) -> Vec<Equation> {
    let mut equations = common(frame, u);
    let (a, p) = (&u.a, &frame.p);
    equations.push((
        middle_of_layer_1(frame, u),
        u.mean_near(&[(0.5, [a, &p[0], &p[2]]), (0.5, [a, &p[1], &p[3]])]),
    ));
    for k in 0..4 {
        let (before, after, opposite) = (frame.before(k), frame.after(k), (k + 2) % 4);
        // Of the two rational values near a corner, the mean.
        let beside = |j: usize, end: usize| p[j] - p[end];
        let by = |edge: usize, to: usize, out: usize, other: Vec3| {
            let g = frame.middle[edge];
            frame.at_corner(k, &p[to]) + (frame.n[k].dot(&other) + 2.0 * g.dot(&beside(out, k))) / 9.0
        };
        let forward = by(k, after, before, beside(opposite, after));
        let backward = by(before, before, after, beside(opposite, before));
        // The quadratic over the bilinear base, raised to degree 3 in both directions.
        let near = polar_mean(
            u,
            &[
                (1.0 / 9.0, [&p[k], &p[k]]),
                (2.0 / 9.0, [&p[k], &p[after]]),
                (2.0 / 9.0, [&p[k], &p[before]]),
                (2.0 / 9.0, [&p[k], &p[opposite]]),
                (2.0 / 9.0, [&p[after], &p[before]]),
            ],
        );
        equations.push((u.fixed(0.5 * (forward + backward)), near));
    }
    equations
}

/// A mean of values of the quadratic's symmetric form, and of the linear function at the middles.
fn polar_mean(u: &Unknowns, weighted: &[(f64, [&Point3; 2])]) -> [Affine; 2] {
    let mut sums = [u.fixed(0.0), u.fixed(0.0)];
    for (weight, [x, y]) in weighted {
        for j in 0..QUADRATIC {
            let mut coefficients = [0.0; QUADRATIC];
            coefficients[j] = u.length;
            let one = Quadric { coefficients, center: u.center, scale: u.length };
            sums[0].slope[j] += weight * one.polar(x, y);
        }
        let middle = 0.5 * (*x + *y);
        let [_, linear] = u.near(&middle, &middle, &middle);
        sums[1] = &sums[1] + &(*weight * &linear);
    }
    sums
}

/// p_111: the mean of what the four sides ask for (Sub-algorithm 2).
fn middle_of_layer_1(frame: &PolygonFrame, u: &Unknowns) -> Affine {
    let (a, p) = (&u.a, &frame.p);
    let mut sum = u.fixed(0.0);
    for k in 0..4 {
        let (next, before) = (frame.after(k), frame.before(k));
        let behind = frame.after(next);
        let b = barycentric([*a, p[behind], p[next], p[k]], &p[before]);
        let edge = |k: usize| u.fixed(frame.on_edge(k, a));
        let corner = |k: usize| u.fixed(frame.at_corner(k, a));
        let at_start = Affine::sum(
            [1.0 / b[1], -b[0] / b[1], -b[2] / b[1], -b[3] / b[1]],
            [&edge(before), &u.towards(&p[k]), &edge(k), &corner(k)],
        );
        let at_end = Affine::sum(b, [&u.towards(&p[next]), &edge(next), &corner(next), &edge(k)]);
        sum = &sum + &(0.125 * &(&at_start + &at_end));
    }
    sum
}
