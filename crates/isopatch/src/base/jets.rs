//! What is known of the field at many points.

use crate::field::Field;
use crate::geom::{Jet, Jets, Point3, Points};
use crate::parallel::Evenly;
use rayon::prelude::*;

/// Points that one task evaluates together; the result does not depend on it.
const TASK: usize = 64;

/// What `take` makes of the jet at each point. Points are evaluated in batches, by all threads.
pub(super) fn of_jets<T: Clone + Default + Send>(
    field: &dyn Field,
    positions: &[Point3],
    take: impl Fn(&Jet) -> T + Sync,
) -> Vec<T> {
    let of_batch = |(batch, taken): (&[Point3], &mut [T])| {
        let points: Points = batch.iter().copied().collect();
        let mut jets = Jets::zeros(batch.len());
        field.jets(points.view(), &mut jets);
        taken.iter_mut().enumerate().for_each(|(i, taken)| *taken = take(&jets.get(i)));
    };
    let mut taken = vec![T::default(); positions.len()];
    positions.par_chunks(TASK).zip(taken.par_chunks_mut(TASK)).evenly().for_each(of_batch);
    taken
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::base::test_fields::field;

    #[test]
    fn batches_give_the_jets_of_the_points_in_order() {
        let torus = field("(sqrt(x^2+y^2)-2)^2+z^2-1");
        for count in [0, 1, TASK, 2 * TASK + 1] {
            let point = |i: usize| Point3::new(3.0 + (i as f64).sin(), 0.1 * i as f64, 0.5);
            let positions: Vec<Point3> = (0..count).map(point).collect();
            let one_by_one: Vec<Jet> = positions.iter().map(|p| torus.jet(*p)).collect();
            assert_eq!(of_jets(&torus, &positions, Clone::clone), one_by_one);
        }
    }
}
