//! A straight line through what is seen, by least squares.

/// Sums of y over x.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub(super) struct Line {
    pub(super) count: f32,
    x: f32,
    y: f32,
    xx: f32,
    xy: f32,
}

impl Line {
    #[inline(never)]
    pub(super) fn add(&mut self, x: f32, y: f32) {
        self.count += 1.0;
        self.x += x;
        self.y += y;
        self.xx += x * x;
        self.xy += x * y;
    }

    /// By how much y rises with x, and y where x is 0. NaN of less than two points.
    #[inline(never)]
    pub(super) fn solve(&self) -> (f32, f32) {
        let spread = self.count * self.xx - self.x * self.x;
        let rise = (self.count * self.xy - self.x * self.y) / spread;
        (rise, (self.y - rise * self.x) / self.count)
    }
}
