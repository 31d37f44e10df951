//! The way the boat has come, for SMART_RTL.

use helmlink_mission::geodesy::NorthEast;

/// Points along the way since arming. When it is full, every other point goes.
#[derive(Debug, Clone, Default)]
pub(super) struct Breadcrumbs {
    points: Vec<NorthEast>,
}

impl Breadcrumbs {
    /// Starts anew.
    pub(super) fn clear(&mut self) {
        *self = Self::default();
    }

    /// Drops a point if the boat is `spacing_m` away from the last one. At most `capacity` are kept.
    pub(super) fn drop_at(&mut self, position: NorthEast, spacing_m: f64, capacity: usize) {
        if self.points.last().is_some_and(|last| (position - *last).norm() < spacing_m) {
            return;
        }
        if self.points.len() >= capacity.max(2) {
            let mut number = 0;
            self.points.retain(|_| {
                number += 1;
                number % 2 == 1
            });
        }
        self.points.push(position);
    }

    /// Whether there is nowhere to go back to.
    pub(super) fn is_empty(&self) -> bool {
        self.points.is_empty()
    }

    /// The next point on the way back; it is taken up.
    pub(super) fn next(&mut self) -> Option<NorthEast> {
        self.points.pop()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn leads_back_in_reverse_and_stays_small() {
        let mut crumbs = Breadcrumbs::default();
        for step in 0..10_000 {
            crumbs.drop_at(NorthEast::new(f64::from(step), 0.0), 2.0, 300);
        }
        assert!(crumbs.points.len() <= 300);
        let mut last = f64::MAX;
        while let Some(point) = crumbs.next() {
            assert!(point.north_m < last);
            last = point.north_m;
        }
        assert_eq!(last, 0.0, "the start is kept");
    }
}
