//! Boxes that touch, as one.

use super::cell::Cell;
use crate::geom::{Aabb, Point3};
use std::collections::HashMap;

/// Numbers of the boxes of each connected set, in the order of the first; boxes that share a corner are connected.
pub(super) fn clusters(cells: &[Cell]) -> Vec<Vec<usize>> {
    let size = cells.iter().fold(Point3::zeros(), |s, c| s.sup(&c.bounds.size()));
    let margin = 1e-9 * size.max();
    let bucket = |p: Point3| [0, 1, 2].map(|a| (p[a] / size[a].max(f64::MIN_POSITIVE)).floor() as i64);
    let mut grid: HashMap<[i64; 3], Vec<usize>> = HashMap::new();
    for (i, cell) in cells.iter().enumerate() {
        grid.entry(bucket(cell.bounds.center())).or_default().push(i);
    }
    let mut cluster = vec![usize::MAX; cells.len()];
    let mut result: Vec<Vec<usize>> = Vec::new();
    for first in 0..cells.len() {
        if cluster[first] != usize::MAX {
            continue;
        }
        let number = result.len();
        let mut members = vec![first];
        cluster[first] = number;
        let mut next = 0;
        while next < members.len() {
            let bounds = cells[members[next]].bounds.grown(margin);
            next += 1;
            let [x, y, z] = bucket(bounds.center());
            let near = (x - 1..=x + 1).flat_map(|x| (y - 1..=y + 1).flat_map(move |y| (z - 1..=z + 1).map(move |z| [x, y, z])));
            for &other in near.filter_map(|key| grid.get(&key)).flatten() {
                if cluster[other] == usize::MAX && cells[other].bounds.overlaps(&bounds) {
                    cluster[other] = number;
                    members.push(other);
                }
            }
        }
        result.push(members);
    }
    result
}

/// The box around some of the boxes.
pub(super) fn hull<'a>(cells: impl IntoIterator<Item = &'a Cell>) -> Aabb {
    cells.into_iter().fold(Aabb::EMPTY, |hull, cell| hull.union(&cell.bounds))
}
