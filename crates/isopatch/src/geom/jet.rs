use super::{Mat3, Points, Vec3};

/// Value, gradient and Hessian of a scalar function at a point.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
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

/// Rows and columns of the numbers of a symmetric matrix that [`Jets`] keeps.
const UPPER: [(usize, usize); 6] = [(0, 0), (0, 1), (0, 2), (1, 1), (1, 2), (2, 2)];

/// Jets at many points as one array per number, the layout that batch evaluation wants.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Jets {
    /// f.
    pub value: Vec<f64>,
    /// ∇f.
    pub gradient: Points,
    /// The upper triangle of ∇²f by rows: xx, xy, xz, yy, yz, zz.
    pub hessian: [Vec<f64>; 6],
}

impl Jets {
    /// `n` jets of the zero function.
    pub fn zeros(n: usize) -> Self {
        let zeros = || vec![0.0; n];
        Self { value: zeros(), gradient: Points::zeros(n), hessian: std::array::from_fn(|_| zeros()) }
    }

    /// Number of jets.
    pub fn len(&self) -> usize {
        self.value.len()
    }

    /// No jets?
    pub fn is_empty(&self) -> bool {
        self.value.is_empty()
    }

    /// The `i`-th jet.
    pub fn get(&self, i: usize) -> Jet {
        let [xx, xy, xz, yy, yz, zz] = [0, 1, 2, 3, 4, 5].map(|k| self.hessian[k][i]);
        let hessian = Mat3::new(xx, xy, xz, xy, yy, yz, xz, yz, zz);
        Jet { value: self.value[i], gradient: self.gradient.get(i), hessian }
    }

    /// Replaces the `i`-th jet.
    pub fn set(&mut self, i: usize, jet: &Jet) {
        self.value[i] = jet.value;
        self.gradient.set(i, jet.gradient);
        for (numbers, place) in self.hessian.iter_mut().zip(UPPER) {
            numbers[i] = jet.hessian[place];
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// f = x²/a² + y²/b² + z²/c² − 1 at its vertex (a, 0, 0), where the principal curvatures are −a/b² and −a/c².
    #[test]
    fn an_ellipsoid_has_its_known_curvatures() {
        let (a, b, c) = (3.0f64, 2.0f64, 0.5f64);
        let hessian = Mat3::from_diagonal(&Vec3::new(2.0 / (a * a), 2.0 / (b * b), 2.0 / (c * c)));
        let jet = Jet { value: 0.0, gradient: Vec3::new(2.0 / a, 0.0, 0.0), hessian };
        let expected = Mat3::from_diagonal(&Vec3::new(0.0, -a / (b * b), -a / (c * c)));
        assert!((jet.curvature_tensor() - expected).amax() < 1e-14);
        // The same surface from −f: the normal turns, and with it the sign.
        let negated = Jet { value: 0.0, gradient: -jet.gradient, hessian: -jet.hessian };
        assert!((negated.curvature_tensor() + expected).amax() < 1e-14);
    }

    #[test]
    fn the_normal_is_no_direction_of_curvature() {
        let gradient = Vec3::new(0.3, -1.2, 0.7);
        let hessian = Mat3::new(1.0, 2.0, -0.5, 2.0, 0.3, 4.0, -0.5, 4.0, -2.0);
        let m = Jet { value: 0.0, gradient, hessian }.curvature_tensor();
        assert!((m * gradient).amax() < 1e-14 && (m - m.transpose()).amax() == 0.0);
        // tᵀMt = −tᵀHt/|∇f| for tangents t.
        let t = gradient.cross(&Vec3::x());
        assert!((t.dot(&(m * t)) + t.dot(&(hessian * t)) / gradient.norm()).abs() < 1e-13);
    }
}
