use super::Point3;

/// Many points as one array per coordinate, the layout that batch evaluation wants.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Points {
    /// First coordinates.
    pub x: Vec<f64>,
    /// Second coordinates.
    pub y: Vec<f64>,
    /// Third coordinates.
    pub z: Vec<f64>,
}

/// A borrowed run of [`Points`]; the three slices have the same length.
#[derive(Clone, Copy, Debug)]
pub struct PointsView<'a> {
    /// First coordinates.
    pub x: &'a [f64],
    /// Second coordinates.
    pub y: &'a [f64],
    /// Third coordinates.
    pub z: &'a [f64],
}

/// A mutable run of [`Points`] (or of vectors, such as gradients); the three slices have the same length.
#[derive(Debug)]
pub struct PointsMut<'a> {
    /// First coordinates.
    pub x: &'a mut [f64],
    /// Second coordinates.
    pub y: &'a mut [f64],
    /// Third coordinates.
    pub z: &'a mut [f64],
}

impl Points {
    /// `n` points at the origin.
    pub fn zeros(n: usize) -> Self {
        Self { x: vec![0.0; n], y: vec![0.0; n], z: vec![0.0; n] }
    }

    /// No points, and room for `n`.
    pub fn with_capacity(n: usize) -> Self {
        Self { x: Vec::with_capacity(n), y: Vec::with_capacity(n), z: Vec::with_capacity(n) }
    }

    /// Number of points.
    pub fn len(&self) -> usize {
        self.x.len()
    }

    /// No points?
    pub fn is_empty(&self) -> bool {
        self.x.is_empty()
    }

    /// Forgets all points, keeps the memory.
    pub fn clear(&mut self) {
        self.x.clear();
        self.y.clear();
        self.z.clear();
    }

    /// Forgets all but the first `count` points.
    pub fn truncate(&mut self, count: usize) {
        self.x.truncate(count);
        self.y.truncate(count);
        self.z.truncate(count);
    }

    /// Makes them `count` points: the first ones, or all and more at the origin.
    pub fn resize(&mut self, count: usize) {
        self.x.resize(count, 0.0);
        self.y.resize(count, 0.0);
        self.z.resize(count, 0.0);
    }

    /// Appends a point.
    pub fn push(&mut self, p: Point3) {
        self.x.push(p.x);
        self.y.push(p.y);
        self.z.push(p.z);
    }

    /// The `i`-th point.
    pub fn get(&self, i: usize) -> Point3 {
        Point3::new(self.x[i], self.y[i], self.z[i])
    }

    /// Replaces the `i`-th point.
    pub fn set(&mut self, i: usize, p: Point3) {
        self.x[i] = p.x;
        self.y[i] = p.y;
        self.z[i] = p.z;
    }

    /// All of them, borrowed.
    pub fn view(&self) -> PointsView<'_> {
        PointsView { x: &self.x, y: &self.y, z: &self.z }
    }

    /// All of them, mutably borrowed.
    pub fn view_mut(&mut self) -> PointsMut<'_> {
        PointsMut { x: &mut self.x, y: &mut self.y, z: &mut self.z }
    }

    /// The points of the index range, mutably borrowed.
    pub fn slice_mut(&mut self, range: std::ops::Range<usize>) -> PointsMut<'_> {
        PointsMut { x: &mut self.x[range.clone()], y: &mut self.y[range.clone()], z: &mut self.z[range] }
    }
}

impl FromIterator<Point3> for Points {
    fn from_iter<T: IntoIterator<Item = Point3>>(iter: T) -> Self {
        let iter = iter.into_iter();
        let mut points = Self::with_capacity(iter.size_hint().0);
        iter.for_each(|p| points.push(p));
        points
    }
}

impl PointsMut<'_> {
    /// The same points, borrowed for a shorter time.
    pub fn reborrow(&mut self) -> PointsMut<'_> {
        PointsMut { x: self.x, y: self.y, z: self.z }
    }
}

impl<'a> PointsView<'a> {
    /// Number of points.
    pub fn len(&self) -> usize {
        self.x.len()
    }

    /// No points?
    pub fn is_empty(&self) -> bool {
        self.x.is_empty()
    }

    /// The `i`-th point.
    pub fn get(&self, i: usize) -> Point3 {
        Point3::new(self.x[i], self.y[i], self.z[i])
    }

    /// The points of the index range.
    pub fn slice(&self, range: std::ops::Range<usize>) -> PointsView<'a> {
        PointsView { x: &self.x[range.clone()], y: &self.y[range.clone()], z: &self.z[range] }
    }
}
