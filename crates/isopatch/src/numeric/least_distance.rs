//! Small least-squares problems with inequalities: non-negative unknowns, and the point of a polyhedron nearest to the origin.
//!
//! Lawson & Hanson, Solving Least Squares Problems, 1974, chapter 23. Active sets, with a bound on the steps; meant for a few
//! dozen unknowns.

use nalgebra::{DMatrix, DVector};

/// Steps for each unknown after which the active set is taken as it is: it settles after one or two.
const STEPS_PER_UNKNOWN: usize = 3;

/// Entries of the gradient below this, relative to the size of the data, are rounding.
const ROUNDING: f64 = 1e-13;

/// Singular values below this, relative to 1 (columns have length 1), are zero.
const SINGULAR: f64 = 1e-14;

/// The x ≥ 0 for which |A x − b| is least.
///
/// It satisfies the conditions of Karush, Kuhn and Tucker: Aᵀ(b − A x) is 0 where x > 0 and at most 0 where x = 0. Takes at most
/// three steps an unknown, each with a dense solution.
pub fn nonnegative(a: &DMatrix<f64>, b: &DVector<f64>) -> DVector<f64> {
    let count = a.ncols();
    let mut x = DVector::zeros(count);
    let mut free: Vec<usize> = Vec::new();
    let lengths: Vec<f64> = a.column_iter().map(|c| c.norm()).collect();
    for _ in 0..STEPS_PER_UNKNOWN * count {
        let descent = a.tr_mul(&(b - a * &x));
        let is_worth = |j: &usize| descent[*j] > ROUNDING * lengths[*j] * b.norm() && !free.contains(j);
        let steepest = |i: &usize, j: &usize| {
            (descent[*i] / lengths[*i]).total_cmp(&(descent[*j] / lengths[*j])).then(j.cmp(i))
        };
        let Some(entering) = (0..count).filter(is_worth).max_by(steepest) else { break };
        free.push(entering);
        let before = free.len();
        reduce(a, b, &mut x, &mut free);
        // What was let in and thrown out again at once was let in by rounding.
        if free.len() < before && !free.contains(&entering) && x[entering] == 0.0 {
            break;
        }
    }
    x
}

/// Moves x to the least-squares solution over the free unknowns; those that would become negative on the way are freed no longer.
fn reduce(a: &DMatrix<f64>, b: &DVector<f64>, x: &mut DVector<f64>, free: &mut Vec<usize>) {
    while !free.is_empty() {
        let wanted = solution(a, b, free);
        let blocked = |(k, j): (usize, &usize)| {
            (wanted[k] <= 0.0).then(|| (x[*j] / (x[*j] - wanted[k]), *j)).filter(|(step, _)| step.is_finite())
        };
        let shortest = free.iter().enumerate().filter_map(blocked).min_by(|p, q| p.0.total_cmp(&q.0));
        let step = shortest.map_or(1.0, |(step, _)| step);
        for (k, j) in free.iter().enumerate() {
            x[*j] += step * (wanted[k] - x[*j]);
        }
        let Some((_, leaving)) = shortest else {
            free.iter().for_each(|j| x[*j] = x[*j].max(0.0));
            return;
        };
        free.retain(|j| *j != leaving && x[*j] > 0.0);
        for j in 0..x.len() {
            if !free.contains(&j) {
                x[j] = 0.0;
            }
        }
    }
}

/// Least-squares solution with the given columns alone.
fn solution(a: &DMatrix<f64>, b: &DVector<f64>, columns: &[usize]) -> DVector<f64> {
    let chosen = a.select_columns(columns);
    let lengths: Vec<f64> = chosen.column_iter().map(|c| c.norm().max(f64::MIN_POSITIVE)).collect();
    let scaled = DMatrix::from_fn(chosen.nrows(), columns.len(), |i, j| chosen[(i, j)] / lengths[j]);
    let solved = scaled.svd(true, true).solve(b, SINGULAR);
    let solved = solved.unwrap_or_else(|_| DVector::zeros(columns.len()));
    DVector::from_fn(columns.len(), |j, _| solved[j] / lengths[j])
}

/// A solution this far away (in units of the unknowns) is none: the inequalities all but contradict each other.
const FARTHEST: f64 = 1e5;

/// How far an inequality may be missed by, relative to its row and to the solution.
const MISSED: f64 = 1e-9;

/// The x nearest to the origin with A x ≥ b, row by row; none if there is none, or none within 1e5.
///
/// Least-distance programming through the dual problem: with E = \[Aᵀ; bᵀ\] and the last unit vector f, the residual r = E u − f
/// of the non-negative least-squares solution u gives x = −r_1..n / r_n+1.
pub fn least_distance(a: &DMatrix<f64>, b: &DVector<f64>) -> Option<DVector<f64>> {
    let (rows, unknowns) = a.shape();
    // A row of length 1 each, so that none weighs more than another.
    let length: Vec<f64> =
        (0..rows).map(|i| a.row(i).norm().max(b[i].abs()).max(f64::MIN_POSITIVE)).collect();
    let entry = |i: usize, j: usize| if i < unknowns { a[(j, i)] } else { b[j] } / length[j];
    let dual = DMatrix::from_fn(unknowns + 1, rows, entry);
    let last = DVector::from_fn(unknowns + 1, |i, _| if i == unknowns { 1.0 } else { 0.0 });
    let residual = &dual * nonnegative(&dual, &last) - &last;
    let x = -residual.rows(0, unknowns) / residual[unknowns];
    let is_met = |i: usize| {
        let slack = (a.row(i) * &x)[0] - b[i];
        slack >= -MISSED * length[i] * (1.0 + x.norm())
    };
    (x.norm() < FARTHEST && (0..rows).all(is_met)).then_some(x)
}

#[cfg(test)]
#[allow(clippy::unwrap_used)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    fn random(rows: usize, columns: usize) -> impl Strategy<Value = (DMatrix<f64>, DVector<f64>)> {
        let matrix = prop::collection::vec(-1.0..1.0f64, rows * columns);
        let vector = prop::collection::vec(-1.0..1.0f64, rows);
        (matrix, vector).prop_map(move |(m, v)| (DMatrix::from_vec(rows, columns, m), DVector::from_vec(v)))
    }

    proptest! {
        /// Aᵀ(b − A x) vanishes where x > 0 and is not positive elsewhere.
        #[test]
        fn nonnegative_solutions_are_optimal((a, b) in random(9, 14)) {
            let x = nonnegative(&a, &b);
            let descent = a.tr_mul(&(&b - &a * &x));
            for j in 0..14 {
                prop_assert!(x[j] >= 0.0 && descent[j] < 1e-10);
                prop_assert!(x[j] == 0.0 || descent[j].abs() < 1e-10);
            }
        }

        /// The nearest point is a combination of the rows that hold with equality, with weights ≥ 0.
        #[test]
        fn nearest_points_are_optimal((a, b) in random(18, 4), inside in prop::collection::vec(-2.0..2.0f64, 4)) {
            // Bounds that the point `inside` meets with some room.
            let b = &a * DVector::from_vec(inside) - b.abs();
            let x = least_distance(&a, &b).unwrap();
            let slack = &a * &x - &b;
            prop_assert!(slack.min() > -1e-9);
            let active: Vec<usize> = (0..18).filter(|i| slack[*i] < 1e-7).collect();
            let weights = nonnegative(&a.select_rows(&active).transpose(), &x);
            prop_assert!((a.select_rows(&active).transpose() * weights - &x).norm() < 1e-6 * (1.0 + x.norm()));
        }
    }

    #[test]
    fn half_planes_are_met_where_they_cross() {
        let a = DMatrix::from_row_slice(3, 2, &[1.0, 0.0, 0.0, 1.0, -1.0, -1.0]);
        let x = least_distance(&a, &DVector::from_vec(vec![1.0, 2.0, -10.0])).unwrap();
        assert!((x - DVector::from_vec(vec![1.0, 2.0])).norm() < 1e-12);
        // Already met: nothing moves.
        assert_eq!(least_distance(&a, &DVector::from_vec(vec![-1.0, -2.0, -10.0])).unwrap().norm(), 0.0);
    }

    #[test]
    fn contradictions_have_no_solution() {
        let a = DMatrix::from_row_slice(2, 1, &[1.0, -1.0]);
        assert_eq!(least_distance(&a, &DVector::from_vec(vec![1.0, 1.0])), None);
        let nothing = DMatrix::from_row_slice(1, 1, &[0.0]);
        assert_eq!(least_distance(&nothing, &DVector::from_vec(vec![1.0])), None);
    }
}
