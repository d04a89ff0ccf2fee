//! The two halves of a queue of segments.

use super::MOST_AXES;
use super::admission::Admission;
use super::begin::SegmentConfig;
use super::halves::{Receiver, Sender};
use super::player::Player;
use super::queue::SegmentQueue;
use crate::config::{AxisLimits, ramp};
use crate::rate::Rate;

impl<const AXES: usize, const SEGMENTS: usize> SegmentQueue<AXES, SEGMENTS> {
    /// Both halves, for axes with these limits; `None` for no axis and for more than `AXES` or [`MOST_AXES`].
    pub fn split(
        &mut self,
        limits: &[AxisLimits],
        config: SegmentConfig,
    ) -> Option<(Admission<'_, AXES>, Player<'_, AXES>)> {
        let axes = limits.len();
        let first = limits.first()?;
        if axes > AXES || axes > MOST_AXES {
            return None;
        }
        let mut all = [*first; AXES];
        all.iter_mut()
            .zip(limits)
            .for_each(|(all, one)| *all = *one);
        let (most, change) = ramp(limits);
        let standing = Rate::standing(most, change);
        let (admit, admitted) = self.segments.split();
        let (order, orders) = self.orders.split();
        let (admit, order) = (Sender::new(admit), Sender::new(order));
        let (admitted, orders) = (Receiver::new(admitted), Receiver::new(orders));
        let player = Player::new(admitted, orders, &self.shared, axes, standing, config.lead);
        let admission = Admission::new(admit, order, &self.shared, (axes, all), config);
        Some((admission, player))
    }
}
