use super::{Mat3, Vec3};

/// Value, gradient and Hessian of a scalar function at a point.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Jet {
    /// f.
    pub value: f64,
    /// ∇f.
    pub gradient: Vec3,
    /// ∇²f, symmetric.
    pub hessian: Mat3,
}

impl Jet {
    /// The curvature tensor M = −P H P / |∇f|, P = I − N Nᵀ, of the level set through the point.
    ///
    /// For a unit tangent t, tᵀ M t is the normal curvature κ n·N with N = ∇f/|∇f|: negative where the surface
    /// bends away from N, so −1/R on a sphere of radius R. Tong & Kim 2009, eqs. (5) and (6), with the
    /// sign that their eq. (8) needs and the symmetric projection on both sides (PAPERS.md, misprints).
    pub fn curvature_tensor(&self) -> Mat3 {
        let length = self.gradient.norm();
        let n = self.gradient / length;
        let p = Mat3::identity() - n * n.transpose();
        let m = -(p * self.hessian * p) / length;
        0.5 * (m + m.transpose())
    }
}
