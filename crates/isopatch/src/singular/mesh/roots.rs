//! All simple real roots of a polynomial on an interval, from its values: Descartes' rule of signs in Bernstein form.

use nalgebra::DMatrix;

/// Isolates the roots of polynomials up to a degree.
pub(super) struct Isolator {
    degree: usize,
    /// Where a polynomial is evaluated: Chebyshev–Lobatto points of [0, 1], the ends among them.
    nodes: Vec<f64>,
    /// From the values there to Bernstein coefficients, by rows.
    to_bernstein: DMatrix<f64>,
}

/// Bisections until two roots that are not yet apart count as none: they are then closer than the 2⁻⁴⁰th part.
const MAX_DEPTH: usize = 40;
/// Where intervals are divided: roots of simple polynomials are rarely there.
const SPLIT: f64 = 0.4871;
/// Steps of the search in an interval with one root; each takes at least half of the interval every third time.
const SEARCH_STEPS: usize = 200;

impl Isolator {
    /// For polynomials of at most this degree. None if the degree is too large for that in floats.
    pub(super) fn new(degree: usize) -> Option<Self> {
        let at = |j: usize| 0.5 - 0.5 * (std::f64::consts::PI * j as f64 / degree.max(1) as f64).cos();
        let nodes: Vec<f64> = (0..=degree).map(at).collect();
        let collocation = DMatrix::from_fn(degree + 1, degree + 1, |j, i| bernstein(degree, i, nodes[j]));
        let to_bernstein = collocation.try_inverse()?;
        Some(Self { degree, nodes, to_bernstein })
    }

    /// The parameters in (0, 1) at which f changes its sign, ascending. A value of 0 counts as positive. The number is even
    /// if and only if f has the same sign at both ends.
    pub(super) fn roots(&self, f: &dyn Fn(f64) -> f64) -> Vec<f64> {
        let values: Vec<f64> = self.nodes.iter().map(|t| f(*t)).collect();
        let mut b: Vec<f64> = (0..=self.degree)
            .map(|i| values.iter().enumerate().map(|(j, v)| self.to_bernstein[(i, j)] * v).sum())
            .collect();
        // The ends are exact, so that the parity is right.
        (b[0], b[self.degree]) = (values[0], values[self.degree]);
        let mut found = Vec::new();
        isolate(b, [0.0, 1.0], 0, f, &mut found);
        found
    }
}

fn bernstein(n: usize, i: usize, t: f64) -> f64 {
    let binomial: f64 = (0..i).map(|k| (n - k) as f64 / (k + 1) as f64).product();
    binomial * t.powi(i as i32) * (1.0 - t).powi((n - i) as i32)
}

fn is_positive(f: f64) -> bool {
    f >= 0.0
}

fn isolate(b: Vec<f64>, [lo, hi]: [f64; 2], depth: usize, f: &dyn Fn(f64) -> f64, found: &mut Vec<f64>) {
    let variations = b.windows(2).filter(|w| is_positive(w[0]) != is_positive(w[1])).count();
    match variations {
        0 => {}
        1 => found.push(search(&b, [lo, hi], f)),
        _ if depth == MAX_DEPTH => {
            if is_positive(b[0]) != is_positive(b[b.len() - 1]) {
                found.push(search(&b, [lo, hi], f));
            }
        }
        _ => {
            let mid = lo + SPLIT * (hi - lo);
            let (left, right) = split(b, SPLIT);
            isolate(left, [lo, mid], depth + 1, f, found);
            isolate(right, [mid, hi], depth + 1, f, found);
        }
    }
}

/// De Casteljau: the coefficients on both sides of t.
fn split(mut b: Vec<f64>, t: f64) -> (Vec<f64>, Vec<f64>) {
    let n = b.len();
    let mut left = Vec::with_capacity(n);
    for r in 0..n {
        left.push(b[0]);
        for i in 0..n - 1 - r {
            b[i] += t * (b[i + 1] - b[i]);
        }
    }
    // b[i] is now the coefficient of level n − 1 − i: the right half from its beginning.
    (left, b)
}

/// The root in an interval with one: of f itself if it changes its sign there, else of its Bernstein form.
fn search(b: &[f64], [lo, hi]: [f64; 2], f: &dyn Fn(f64) -> f64) -> f64 {
    let (at_lo, at_hi) = (f(lo), f(hi));
    if is_positive(at_lo) != is_positive(at_hi) {
        return falsi(f, [lo, hi], [at_lo, at_hi]);
    }
    let form = |t: f64| split(b.to_vec(), (t - lo) / (hi - lo)).1[0];
    falsi(&form, [lo, hi], [b[0], b[b.len() - 1]])
}

/// Regula falsi by the Illinois rule, with a bisection every third time.
fn falsi(f: &dyn Fn(f64) -> f64, [mut a, mut b]: [f64; 2], [mut fa, mut fb]: [f64; 2]) -> f64 {
    let positive = is_positive(fa);
    for step in 0..SEARCH_STEPS {
        let middle = 0.5 * (a + b);
        let secant = (a * fb - b * fa) / (fb - fa);
        let inside = secant > a && secant < b;
        let t = if step % 3 == 2 || !inside { middle } else { secant };
        if t <= a || t >= b {
            return middle;
        }
        let ft = f(t);
        if ft == 0.0 {
            return t;
        }
        if is_positive(ft) == positive {
            (a, fa, fb) = (t, ft, if step % 3 == 2 { fb } else { 0.5 * fb });
        } else {
            (b, fb, fa) = (t, ft, if step % 3 == 2 { fa } else { 0.5 * fa });
        }
    }
    0.5 * (a + b)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn all_roots_are_found_and_double_ones_are_not() {
        let isolator = Isolator::new(8).unwrap();
        let roots = [0.1, 0.1001, 0.35, 0.8, 0.93];
        let f = |t: f64| roots.iter().map(|r| t - r).product::<f64>();
        let found = isolator.roots(&f);
        assert_eq!(found.len(), 5);
        assert!(found.iter().zip(roots).all(|(a, b)| (a - b).abs() < 1e-12), "{found:?}");
        let touching = isolator.roots(&|t| (t - 0.3f64).powi(2) * (t - 0.6));
        assert!(touching.len() % 2 == 1 && (touching[touching.len() - 1] - 0.6).abs() < 1e-12);
        assert!(isolator.roots(&|t| t * t + 1e-3).is_empty());
    }
}
