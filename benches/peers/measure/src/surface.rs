//! The surfaces: f = 0, with f < 0 inside.

use crate::number::{Gradient, Number};

/// One of the surfaces.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Surface {
    /// Tube of radius 1 around a circle of radius 5.
    Torus,
    /// The rounded dodecahedron.
    Dodeca,
    /// Genus 2.
    DoubleTorus,
    /// McMullen's K3 surface.
    McMullen,
    /// Genus 3.
    Chair,
    /// Genus 13.
    Decocube,
}

impl Surface {
    /// All, in the order of the paper.
    pub const ALL: [Self; 6] =
        [Self::Torus, Self::Dodeca, Self::DoubleTorus, Self::McMullen, Self::Chair, Self::Decocube];

    /// The name by which the harness asks for it.
    pub fn name(self) -> &'static str {
        match self {
            Self::Torus => "torus",
            Self::Dodeca => "dodeca",
            Self::DoubleTorus => "dtorus",
            Self::McMullen => "mcmullen",
            Self::Chair => "chair",
            Self::Decocube => "decocube",
        }
    }

    /// The surface of that name.
    pub fn named(name: &str) -> Option<Self> {
        Self::ALL.into_iter().find(|surface| surface.name() == name)
    }

    /// Gives `work` the function as code of its own, so that loops over points are compiled for this formula.
    pub fn with<W: Work<N>, N: Number>(self, work: W) -> W::Output {
        match self {
            Self::Torus => work.run(torus),
            Self::Dodeca => work.run(dodeca),
            Self::DoubleTorus => work.run(double_torus),
            Self::McMullen => work.run(mcmullen),
            Self::Chair => work.run(chair),
            Self::Decocube => work.run(decocube),
        }
    }

    /// f at a point, in any kind of numbers.
    pub fn value<N: Number>(self, point: [N; 3]) -> N {
        struct At<N>([N; 3]);
        impl<N: Number> Work<N> for At<N> {
            type Output = N;
            fn run(self, f: impl Fn([N; 3]) -> N) -> N {
                f(self.0)
            }
        }
        self.with(At(point))
    }

    /// f and ∇f at a point.
    pub fn gradient(self, point: [f64; 3]) -> Gradient {
        self.value(std::array::from_fn(|axis| Gradient::coordinate(point[axis], axis)))
    }
}

/// Something to do with a function.
pub trait Work<N> {
    /// What comes out.
    type Output;
    /// Does it.
    fn run(self, f: impl Fn([N; 3]) -> N) -> Self::Output;
}

fn c<N: Number>(value: f64) -> N {
    N::constant(value)
}

/// (√(x² + y²) − 5)² + z² − 1
#[inline(always)]
fn torus<N: Number>([x, y, z]: [N; 3]) -> N {
    ((x.square() + y.square()).sqrt() - c(5.0)).square() + z.square() - c(1.0)
}

/// x⁶ + y⁶ + z⁶ + 20 (x⁴y² + y⁴z² + z⁴x²) − 1
#[inline(always)]
fn dodeca<N: Number>([x, y, z]: [N; 3]) -> N {
    let [x2, y2, z2] = [x.square(), y.square(), z.square()];
    let [x4, y4, z4] = [x2.square(), y2.square(), z2.square()];
    let mixed = x4.clone() * y2.clone() + y4.clone() * z2.clone() + z4.clone() * x2.clone();
    x4 * x2 + y4 * y2 + z4 * z2 + c::<N>(20.0) * mixed - c(1.0)
}

/// x⁸ − 2x⁶ + x⁴ + 2x⁴y² − 2x²y² + y⁴ + z² − 0.04 = (x²(x² − 1) + y²)² + z² − 0.04
#[inline(always)]
fn double_torus<N: Number>([x, y, z]: [N; 3]) -> N {
    let [x2, y2] = [x.square(), y.square()];
    (x2.clone() * (x2 - c(1.0)) + y2).square() + z.square() - c(0.04)
}

/// (x² + 1)(y² + 1)(z² + 1) + 8xyz − 2
#[inline(always)]
fn mcmullen<N: Number>([x, y, z]: [N; 3]) -> N {
    let product = (x.square() + c(1.0)) * (y.square() + c(1.0)) * (z.square() + c(1.0));
    product + c::<N>(8.0) * x * y * z - c(2.0)
}

/// (x² + y² + z² − 0.95 · 25)² − 0.8 ((z − 5)² − 2x²)((z + 5)² − 2y²)
#[inline(always)]
fn chair<N: Number>([x, y, z]: [N; 3]) -> N {
    let [x2, y2] = [x.square(), y.square()];
    let ball = x2.clone() + y2.clone() + z.square() - c(0.95 * 25.0);
    let low = (z.clone() - c(5.0)).square() - c::<N>(2.0) * x2;
    let high = (z + c(5.0)).square() - c::<N>(2.0) * y2;
    ball.square() - c::<N>(0.8) * low * high
}

/// ((x² + y² − 0.64)² + (z² − 1)²)((y² + z² − 0.64)² + (x² − 1)²)((z² + x² − 0.64)² + (y² − 1)²) − 0.02
#[inline(always)]
fn decocube<N: Number>([x, y, z]: [N; 3]) -> N {
    let ring =
        |a: &N, b: &N, c_: &N| (a.clone() + b.clone() - c(0.64)).square() + (c_.clone() - c(1.0)).square();
    let [x2, y2, z2] = [x.square(), y.square(), z.square()];
    ring(&x2, &y2, &z2) * ring(&y2, &z2, &x2) * ring(&z2, &x2, &y2) - c(0.02)
}
