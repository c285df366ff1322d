//! The order of the coefficients of a triangle, drawn in [the module above](super).

/// Number of coefficients of a triangle of degree `n`.
pub const fn count(n: usize) -> usize {
    (n + 1) * (n + 2) / 2
}

/// Position of b_ijk in the net of degree n = i + j + k.
pub const fn position([_, j, k]: [usize; 3]) -> usize {
    let row = j + k;
    row * (row + 1) / 2 + k
}

/// All (i, j, k) with i + j + k = n, in net order.
pub fn indices(n: usize) -> impl Iterator<Item = [usize; 3]> {
    (0..=n).flat_map(move |row| (0..=row).map(move |k| [n - row, row - k, k]))
}

/// Position of the m-th control point of the row that is `depth` away from edge `edge` (0 is the boundary).
///
/// The row runs from corner `edge` to corner `edge` + 1 and has n − depth + 1 points.
pub const fn row(n: usize, edge: usize, depth: usize, m: usize) -> usize {
    let mut ijk = [0; 3];
    ijk[edge % 3] = n - depth - m;
    ijk[(edge + 1) % 3] = m;
    ijk[(edge + 2) % 3] = depth;
    position(ijk)
}

/// Is b_ijk on the boundary of the net?
pub const fn is_boundary(ijk: [usize; 3]) -> bool {
    ijk[0] == 0 || ijk[1] == 0 || ijk[2] == 0
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn positions_number_the_indices() {
        for n in 0..9 {
            let all: Vec<_> = indices(n).collect();
            assert_eq!(all.len(), count(n));
            assert!(
                all.iter().enumerate().all(|(p, ijk)| position(*ijk) == p && ijk.iter().sum::<usize>() == n)
            );
        }
    }

    #[test]
    fn rows_of_the_three_edges_cover_the_boundary() {
        let mut seen: Vec<usize> = (0..3).flat_map(|e| (0..7).map(move |m| row(7, e, 0, m))).collect();
        seen.sort_unstable();
        let boundary: Vec<_> = indices(7).filter(|i| is_boundary(*i)).map(position).collect();
        assert_eq!(seen, boundary);
        assert_eq!([row(7, 1, 0, 0), row(7, 1, 0, 7)], [position([0, 7, 0]), position([0, 0, 7])]);
        assert_eq!(row(7, 2, 1, 2), position([2, 1, 4]));
    }
}
