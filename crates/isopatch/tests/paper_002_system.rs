//! Bajaj & Xu 1997, section 3: the triangulated system (3.2), what resultants lose without a shear, bounds on precision.
#![allow(clippy::unwrap_used, clippy::panic, reason = "a test that fails by a panic is a test that fails")]

use isopatch::field::{Constants, Formula, Polynomial};
use num_bigint::BigInt;
use num_integer::Integer;
use num_rational::BigRational;
use num_traits::{One, Signed, Zero};

fn polynomial(text: &str) -> Polynomial {
    Formula::parse(text, &Constants::new()).unwrap().polynomial().unwrap().clone()
}

fn whole(n: i64) -> BigRational {
    BigRational::from(BigInt::from(n))
}

/// A polynomial in one variable, lowest first, without zeros at the end.
type Univariate = Vec<BigRational>;

fn trimmed(mut p: Univariate) -> Univariate {
    while p.last().is_some_and(Zero::is_zero) {
        p.pop();
    }
    p
}

fn value(p: &Univariate, x: &BigRational) -> BigRational {
    p.iter().rev().fold(BigRational::zero(), |sum, c| sum * x + c)
}

/// The coefficients of the powers of variable `axis` of f, where the other variables have values.
fn in_one(f: &Polynomial, axis: usize, at: &[BigRational; 3]) -> Univariate {
    let degree = f.terms().map(|(e, _)| e[axis] as usize).max().unwrap_or(0);
    let mut list = vec![BigRational::zero(); degree + 1];
    for (e, c) in f.terms() {
        let others = (0..3).filter(|a| *a != axis).map(|a| at[a].pow(e[a] as i32)).product::<BigRational>();
        list[e[axis] as usize] += c * others;
    }
    list
}

/// The determinant, by elimination.
fn determinant(mut rows: Vec<Vec<BigRational>>) -> BigRational {
    let n = rows.len();
    let mut determinant = BigRational::one();
    for k in 0..n {
        let Some(pivot) = (k..n).find(|r| !rows[*r][k].is_zero()) else { return BigRational::zero() };
        if pivot != k {
            rows.swap(pivot, k);
            determinant = -determinant;
        }
        determinant *= rows[k][k].clone();
        for r in k + 1..n {
            let factor = &rows[r][k] / &rows[k][k];
            for c in k..n {
                let change = &factor * &rows[k][c];
                rows[r][c] -= change;
            }
        }
    }
    determinant
}

/// Sylvester's matrix.
fn sylvester(f: &Univariate, g: &Univariate) -> Vec<Vec<BigRational>> {
    let (m, n) = (f.len() - 1, g.len() - 1);
    let row = |p: &Univariate, shift: usize| {
        let mut row = vec![BigRational::zero(); m + n];
        p.iter().rev().enumerate().for_each(|(k, c)| row[shift + k] = c.clone());
        row
    };
    (0..n).map(|i| row(f, i)).chain((0..m).map(|i| row(g, i))).collect()
}

fn resultant(f: &Univariate, g: &Univariate) -> BigRational {
    determinant(sylvester(f, g))
}

/// The subresultant of order 1, a + b z, as (a, b): determinants of Sylvester's matrix without the last row of each kind.
fn linear_subresultant(f: &Univariate, g: &Univariate) -> [BigRational; 2] {
    let (m, n) = (f.len() - 1, g.len() - 1);
    let rows: Vec<Vec<BigRational>> = sylvester(f, g)
        .into_iter()
        .enumerate()
        .filter(|(i, _)| *i != n - 1 && *i != m + n - 1)
        .map(|(_, row)| row)
        .collect();
    let size = m + n - 2;
    let with = |column: usize| {
        let minor = rows
            .iter()
            .map(|row| row[..size - 1].iter().chain([&row[column]]).cloned().collect::<Vec<BigRational>>());
        determinant(minor.collect())
    };
    // Without these rows everything is a multiple of z: the columns belong to the powers m + n − 2, …, 0 of the rest.
    [with(m + n - 2), with(m + n - 3)]
}

/// The polynomial of degree at most n with these values at 0, 1, …, n.
fn interpolated(values: &[BigRational]) -> Univariate {
    let n = values.len();
    let mut differences = values.to_vec();
    for order in 1..n {
        for i in (order..n).rev() {
            differences[i] = (&differences[i] - &differences[i - 1]) / whole(order as i64);
        }
    }
    let mut result = vec![differences[n - 1].clone()];
    for k in (0..n - 1).rev() {
        // result · (x − k) + difference k
        let mut next = vec![BigRational::zero(); result.len() + 1];
        for (i, c) in result.iter().enumerate() {
            next[i + 1] += c;
            next[i] -= c * whole(k as i64);
        }
        next[0] += &differences[k];
        result = next;
    }
    trimmed(result)
}

/// Coordinates in which a surface is written: x, y, z are replaced by these.
fn sheared(text: &str, [x, y, z]: [&str; 3]) -> String {
    let marked = text.replace('x', "X").replace('y', "Y").replace('z', "Z");
    marked.replace('X', x).replace('Y', y).replace('Z', z)
}

/// f, f_x + λ f_y and f_y + μ f_z: as many equations as unknowns, in generic combinations.
struct System {
    equations: [Polynomial; 3],
}

impl System {
    fn new(text: &str, [lambda, mu]: [i64; 2]) -> Self {
        let f = polynomial(text);
        let d = [0, 1, 2].map(|a| f.derivative(a));
        let sum = |p: &Polynomial, q: &Polynomial, factor: i64| {
            let terms = p.terms().map(|(e, c)| (e, c.clone()));
            Polynomial::from_terms(terms.chain(q.terms().map(|(e, c)| (e, c * whole(factor)))))
        };
        let equations = [f, sum(&d[0], &d[1], lambda), sum(&d[1], &d[2], mu)];
        Self { equations }
    }

    /// r_j(x, y) = Res_z(equation 0, equation j) at a place.
    fn projected(&self, j: usize, x: &BigRational, y: &BigRational) -> BigRational {
        let at = [x.clone(), y.clone(), BigRational::zero()];
        let [f, g] = [0, j].map(|i| in_one(&self.equations[i], 2, &at));
        resultant(&f, &g)
    }

    /// r_j as a polynomial in y, of degree at most `degree`, at a given x.
    fn in_y(&self, j: usize, x: &BigRational, degree: usize) -> Univariate {
        let values: Vec<BigRational> = (0..=degree).map(|k| self.projected(j, x, &whole(k as i64))).collect();
        let mut p = interpolated(&values);
        p.resize(degree + 1, BigRational::zero());
        p
    }

    /// The bound of Bézout for the degree of r_j.
    fn degree(&self, j: usize) -> usize {
        (self.equations[0].degree() * self.equations[j].degree()) as usize
    }

    /// The triangulated system (3.2) at a root x of its first polynomial: R(x) = 0 with R = Res_y(r₁, r₂), then y from the
    /// linear subresultant of r₁ and r₂ by y, then z from that of the equations by z. None where one vanishes.
    fn back(&self, x: &BigRational) -> Option<[BigRational; 3]> {
        let rows = [1, 2].map(|j| trimmed(self.in_y(j, x, self.degree(j))));
        let [a, b] = linear_subresultant(&rows[0], &rows[1]);
        if b.is_zero() {
            return None;
        }
        let y = -a / b;
        let at = [x.clone(), y.clone(), BigRational::zero()];
        let [f, g] = [0, 1].map(|i| trimmed(in_one(&self.equations[i], 2, &at)));
        let [a, b] = linear_subresultant(&f, &g);
        (!b.is_zero()).then(|| [x.clone(), y, -a / b])
    }
}

fn is_singular(f: &Polynomial, p: &[BigRational; 3]) -> bool {
    f.value(p).is_zero() && (0..3).all(|a| f.derivative(a).value(p).is_zero())
}

/// A change of coordinates in which every root has an x and a y of its own.
const SHEAR: [&str; 3] = ["(x+2*z)", "(y-3*z+x)", "(z+x+5*y)"];

#[test]
fn a_singular_point_is_lost_without_a_shear_and_found_with_one() {
    // The cone with its tip at (1, 2, −1): f_x and f_y are free of z, so that Res_z(f_x, f_y) is the empty determinant, 1,
    // and projects no point at all.
    let cone = "(x-1)^2+(y-2)^2-(z+1)^2";
    let f = polynomial(cone);
    let at = [whole(1), whole(2), BigRational::zero()];
    let [fx, fy] = [0, 1].map(|a| in_one(&f.derivative(a), 2, &at));
    assert_eq!((fx.len(), fy.len()), (1, 1));
    assert!(resultant(&fx, &fy).is_one());

    // In sheared coordinates, with combinations of the derivatives, (3.2) gives it back exactly.
    let text = sheared(cone, SHEAR);
    let system = System::new(&text, [3, -2]);
    let g = polynomial(&text);
    // The tip solves x + 2z = 1, y − 3z + x = 2, z + x + 5y = −1.
    let rows = vec![
        vec![whole(1), whole(0), whole(2)],
        vec![whole(1), whole(1), whole(-3)],
        vec![whole(1), whole(5), whole(1)],
    ];
    let right = [whole(1), whole(2), whole(-1)];
    let det = determinant(rows.clone());
    let tip = [0, 1, 2].map(|k| {
        let mut replaced = rows.clone();
        (0..3).for_each(|i| replaced[i][k] = right[i].clone());
        determinant(replaced) / &det
    });
    assert!(is_singular(&g, &tip));

    // r₁ and r₂ vanish below the tip, and not elsewhere on the line beside it.
    for j in [1, 2] {
        assert!(system.projected(j, &tip[0], &tip[1]).is_zero());
        assert!(!system.projected(j, &tip[0], &(&tip[1] + whole(1))).is_zero());
    }
    // Below it r₁ and r₂ have a common root in y, at other x they have none.
    let first = |x: &BigRational| {
        let [a, b] = [1, 2].map(|j| trimmed(system.in_y(j, x, system.degree(j))));
        resultant(&a, &b)
    };
    assert!(first(&tip[0]).is_zero());
    assert!(!first(&(&tip[0] + whole(1))).is_zero());
}

#[test]
fn the_triangulated_system_gives_the_points_of_a_regular_system() {
    // Three equations, less their values at a place that is to be their root.
    let root = [2, 3, -2].map(whole);
    let equations = ["x^2+y^2+z^2+x*y", "x+2*y-3*z+x*y", "x-y+z+y*z"].map(|text| {
        let p = polynomial(text);
        let constant = ([0, 0, 0], -p.value(&root));
        Polynomial::from_terms(p.terms().map(|(e, c)| (e, c.clone())).chain([constant]))
    });
    let system = System { equations };
    let found = system.back(&root[0]).unwrap();
    assert_eq!(found, root);
    // At another x the triangle leads to no root.
    let beside = system.back(&whole(5)).unwrap();
    assert!(system.equations.iter().any(|p| !p.value(&beside).is_zero()));
}

/// Sum of the absolute values of the coefficients.
fn length(p: &Univariate) -> BigRational {
    p.iter().map(BigRational::abs).sum()
}

/// Whole coefficients without a common factor.
fn primitive(p: &Univariate) -> Vec<BigInt> {
    let denominators = p.iter().fold(BigInt::one(), |a, c| a.lcm(c.denom()));
    let list: Vec<BigInt> =
        p.iter().map(|c| (c * BigRational::from(denominators.clone())).to_integer()).collect();
    let common = list.iter().fold(BigInt::zero(), |a, c| a.gcd(c));
    list.into_iter().map(|c| c / &common).collect()
}

#[test]
fn coefficients_and_gaps_keep_the_bounds_on_precision() {
    // Hadamard for resultants: |Res(f, g)| ≤ ‖f‖₁^n ‖g‖₁^m, and its coefficients in a parameter, because the 1-norm of a
    // product is at most the product of the 1-norms. Cauchy's gap: a root of a whole polynomial with a₀ ≠ 0 has
    // |root| ≥ |a₀| / (|a₀| + max |aᵢ|), so that this many digits tell 0 from other values.
    for text in ["x^2+y^2-z^3+x*y*z-2", "x^3+y^2*z-5*z^2+x-7", "3*x^2*y-2*z^3+11*z-4*x*y+6"] {
        let system = System::new(text, [2, 5]);
        let x = whole(3);
        for j in [1, 2] {
            let r = trimmed(system.in_y(j, &x, system.degree(j)));
            let [m, n] = [0, j].map(|i| system.equations[i].terms().map(|(e, _)| e[2] as i32).max().unwrap());
            // The 1-norm in (y, z) of the equations at x.
            let norm = |p: &Polynomial| -> BigRational {
                let mut sums: std::collections::BTreeMap<[u32; 2], BigRational> = Default::default();
                p.terms().for_each(|(e, c)| *sums.entry([e[1], e[2]]).or_default() += c * x.pow(e[0] as i32));
                sums.values().map(BigRational::abs).sum()
            };
            let bound = norm(&system.equations[0]).pow(n) * norm(&system.equations[j]).pow(m);
            assert!(length(&r) <= bound, "{text}, r{j}: {} > {bound}", length(&r));
            // The bound is not idle: its number of digits is at most four times the true one.
            let bits = |q: &BigRational| q.to_integer().bits();
            assert!(bits(&bound) <= 4 * bits(&length(&r)), "{text}: {} {}", bits(&bound), bits(&length(&r)));

            let whole_r = primitive(&r);
            let largest = whole_r.iter().map(BigInt::abs).max().unwrap();
            let lowest = whole_r.iter().find(|c| !c.is_zero()).unwrap().abs();
            let gap = BigRational::new(lowest.clone(), &lowest + &largest);
            // No root other than 0 within the gap: |lowest term| outweighs the others.
            let order = whole_r.iter().position(|c| !c.is_zero()).unwrap();
            let rest: Univariate = whole_r[order..].iter().map(|c| BigRational::from(c.abs())).collect();
            let near = &gap * BigRational::new(BigInt::from(999), BigInt::from(1000));
            let others = value(&rest, &near) - &rest[0];
            assert!(rest[0] > others, "{text}");
        }
    }
}

#[test]
fn the_gap_of_a_double_root_needs_more_digits_than_floats_have() {
    // (x² − 2)² and (x² − 2)² − 10⁻²⁰ differ by less than the rounding of floats at x = √2. The value of the second at a
    // critical point is a whole number over 10²⁰, so that 67 binary digits tell it from 0.
    let scale = BigInt::from(10).pow(20);
    let first: Univariate = [4, 0, -4, 0, 1].map(whole).to_vec();
    let mut second = first.clone();
    second[0] -= BigRational::new(BigInt::one(), scale.clone());
    // √2 to 100 binary digits.
    let root = BigRational::new((BigInt::from(2) << 200_u32).sqrt(), BigInt::one() << 100_u32);
    let tolerance = BigRational::new(BigInt::one(), BigInt::one() << 80_u32);
    assert!(value(&first, &root).abs() < tolerance.clone() * tolerance.clone());
    assert!(value(&second, &root).abs() > BigRational::new(BigInt::one(), BigInt::one() << 67_u32));
    let in_floats = |p: &Univariate| {
        use num_traits::ToPrimitive;
        let x = 2.0_f64.sqrt();
        p.iter().rev().fold(0.0, |sum, c| sum * x + c.to_f64().unwrap())
    };
    assert_eq!(in_floats(&first), in_floats(&second));
}
