//! Singular curves, followed step by step from a point on them.

use super::deflation::{Foot, System, solve};
use super::set::CurveSample;
use super::taylor::{sum, unit};
use super::tolerance::is_singular;
use super::unit::UnitPolynomial;
use crate::geom::{Aabb, Point3, Vec3};

/// Distance of samples, in unit coordinates: no point of a curve is farther than a thousandth of the box from one.
pub(super) const STEP: f64 = 1.9e-3;
/// A sample of a closed curve this close to its first one, in steps, is left out.
const REPEATED: f64 = 0.02;
/// A step shorter than this leads nowhere.
const SHORTEST: f64 = 1e-7;
/// A step is taken again at half its length where the curve is farther than this part of it from the tangent, or where
/// the cosine of the turn of the tangent is smaller than this.
const STRAIGHT: f64 = 0.1;
const TURN: f64 = 0.98;
/// Near a special point, steps are this part of the distance to it.
const APPROACH: f64 = 0.3;
/// At this distance from a special point, the curve has arrived there.
const ARRIVED: f64 = 1e-4;
/// A curve that can't be followed any farther, and is no farther than this from a special point, ends there.
pub(super) const NEAR: f64 = 2e-2;
/// Most samples of one arc.
const MOST_SAMPLES: usize = 200_000;
/// Along a curve the Jacobian has rank 2: the second singular value is above this part of the first, the third below that
/// part of the second.
const RANK_TWO: f64 = 1e-7;
const NOT_THREE: f64 = 1e-3;
/// A Hessian with entries below this part of the third derivatives is zero: it is known to the square root of rounding.
const FLAT: f64 = 1e-7;
/// Outside of the box by less than this is rounding.
pub(super) const OUTSIDE: f64 = 1e-9;

/// Where an arc ends.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) enum End {
    /// At the special point of this number.
    Special(usize),
    /// On a side of the box.
    Side(Point3),
    /// Nowhere that is known: the curve can't be followed beyond this point.
    Lost(Point3),
}

/// An arc as it was followed.
#[derive(Clone, Debug)]
pub(super) struct Arc {
    pub system: System,
    /// In unit coordinates.
    pub samples: Vec<CurveSample>,
    /// None if it is closed.
    pub ends: Option<[End; 2]>,
}

/// What curves are followed in.
pub(super) struct Tracer<'a> {
    pub f: &'a UnitPolynomial,
    /// Special points, in unit coordinates.
    pub special: &'a [Point3],
    pub bounds: Aabb,
}

impl Tracer<'_> {
    /// The point of a singular curve nearest to `start`, with the simplest equations that are regular there; none within
    /// `reach`.
    pub fn foot(&self, start: Point3, reach: f64) -> Option<(System, Foot)> {
        System::ALL.iter().find_map(|&system| {
            let foot = self.on_curve(system, start, reach)?;
            // Where the Hessian vanishes, it and its minors are regular by rounding only.
            let uses_hessian = matches!(system, System::Gradient | System::RankOne);
            (!uses_hessian || !self.is_flat(foot.at)).then_some((system, foot))
        })
    }

    /// Does the Hessian vanish, compared with third derivatives?
    fn is_flat(&self, p: Point3) -> bool {
        let taylor = self.f.taylor(p);
        let third = (0..3).flat_map(|a| (a..3).flat_map(move |b| (b..3).map(move |c| [a, b, c])));
        let largest = third.fold(0.0, |m: f64, [a, b, c]| {
            m.max(taylor.derivative(sum(unit(a), sum(unit(b), unit(c)))).abs())
        });
        taylor.hessian().amax() <= FLAT * largest
    }

    fn on_curve(&self, system: System, start: Point3, reach: f64) -> Option<Foot> {
        let foot = solve(self.f, system, start, 2, reach)?;
        let [_, second, third] = foot.sigma;
        let is_curve = second > RANK_TWO && third < NOT_THREE * second;
        (is_curve && is_singular(self.f, foot.at)).then_some(foot)
    }

    /// The whole arc through a point of a curve.
    pub fn arc(&self, system: System, seed: &Foot) -> Arc {
        let sample = |at, tangent| CurveSample { at, tangent };
        let (forward, end) = self.follow(system, seed, seed.tangent);
        let first = sample(seed.at, seed.tangent);
        let Some(end) = end else {
            let samples = std::iter::once(first).chain(forward).collect();
            return Arc { system, samples, ends: None };
        };
        let (backward, begin) = self.follow(system, seed, -seed.tangent);
        let mut samples: Vec<CurveSample> = backward.iter().rev().map(|s| sample(s.at, -s.tangent)).collect();
        samples.push(first);
        samples.extend(forward);
        let begin = begin.unwrap_or(End::Lost(seed.at));
        Arc { system, samples, ends: Some([begin, end]) }
    }

    /// The samples after `seed` in a direction, and where they end; no end where they come back to it.
    fn follow(&self, system: System, seed: &Foot, direction: Vec3) -> (Vec<CurveSample>, Option<End>) {
        let mut samples: Vec<CurveSample> = Vec::new();
        let mut here = CurveSample { at: seed.at, tangent: direction };
        let mut length = STEP;
        while samples.len() < MOST_SAMPLES {
            let (near, distance) = self.nearest_special(here.at);
            if distance < ARRIVED {
                return self.arrive(samples, near);
            }
            let longest = STEP.min(APPROACH * distance.max(ARRIVED));
            length = (1.5 * length).min(longest);
            let next = loop {
                match self.step(system, &here, length) {
                    Some(next) => break Some(next),
                    None if length > SHORTEST => length *= 0.5,
                    None => break None,
                }
            };
            let Some(next) = next else {
                return if distance < NEAR {
                    self.arrive(samples, near)
                } else {
                    (samples, Some(End::Lost(here.at)))
                };
            };
            if !self.bounds.grown(OUTSIDE).contains(&next.at) {
                let last = self.leave(system, &here, length);
                let (near, distance) = self.nearest_special(last.at);
                if distance < ARRIVED {
                    return self.arrive(samples, near);
                }
                samples.push(last);
                return (samples, Some(End::Side(last.at)));
            }
            // One of the samples around the seed is within half a step of it; those on the way out are farther than a step.
            let back = next.at - seed.at;
            if samples.len() > 3 && back.norm() < 0.75 * length && direction.dot(&next.tangent) > 0.5 {
                if direction.dot(&back) < 0.0 && back.norm() > REPEATED * length {
                    samples.push(next);
                }
                return (samples, None);
            }
            samples.push(next);
            here = next;
        }
        (samples, Some(End::Lost(here.at)))
    }

    /// One step along the tangent and back to the curve.
    fn step(&self, system: System, here: &CurveSample, length: f64) -> Option<CurveSample> {
        let predicted = here.at + length * here.tangent;
        let foot = self.on_curve(system, predicted, 0.5 * length)?;
        let tangent = if foot.tangent.dot(&here.tangent) < 0.0 { -foot.tangent } else { foot.tangent };
        let straight =
            (foot.at - predicted).norm() <= STRAIGHT * length && tangent.dot(&here.tangent) >= TURN;
        straight.then_some(CurveSample { at: foot.at, tangent })
    }

    fn nearest_special(&self, p: Point3) -> (usize, f64) {
        let distances = self.special.iter().map(|s| (s - p).norm()).enumerate();
        distances.min_by(|a, b| a.1.total_cmp(&b.1)).unwrap_or((usize::MAX, f64::INFINITY))
    }

    /// Ends the samples in a special point.
    fn arrive(&self, mut samples: Vec<CurveSample>, special: usize) -> (Vec<CurveSample>, Option<End>) {
        let at = self.special[special];
        while samples.last().is_some_and(|last| (last.at - at).norm() < 0.25 * ARRIVED) {
            samples.pop();
        }
        let tangent = samples.last().map_or(Vec3::zeros(), |last| (at - last.at).normalize());
        samples.push(CurveSample { at, tangent });
        (samples, Some(End::Special(special)))
    }

    /// The point where a step of at most this length leaves the box.
    fn leave(&self, system: System, here: &CurveSample, length: f64) -> CurveSample {
        let (mut inside, mut outside) = (0.0, length);
        let mut last = *here;
        while outside - inside > f64::EPSILON {
            let middle = 0.5 * (inside + outside);
            if middle <= inside || middle >= outside {
                break;
            }
            match self.step(system, here, middle) {
                Some(next) if self.bounds.contains(&next.at) => (inside, last) = (middle, next),
                _ => outside = middle,
            }
        }
        // On the side to the bit; the step is down to rounding.
        for a in 0..3 {
            for side in [self.bounds.min[a], self.bounds.max[a]] {
                if (last.at[a] - side).abs() < OUTSIDE {
                    last.at[a] = side;
                }
            }
        }
        last
    }
}
