//! A motion that is known as a whole before it begins.

use board_link::segment::{Begin, Segment};
use dyn_can::DriveId;

use super::segments::{Played, begin};
use crate::board::motion::{Axis, BoardMotion, place};
use crate::board::session::BoardClient;

/// A motion that the board will play.
pub(super) struct WholeMotion {
    pub(super) axes: Vec<Axis>,
    pub(super) segments: Vec<Segment>,
    pub(super) played: Played,
    /// Relative to the start.
    pub(super) last: Vec<i32>,
    pub(super) cycle_us: u32,
    most_percent: u16,
    places: Vec<usize>,
    stand: Vec<i32>,
    /// Segments that were handed to the client.
    offered: usize,
}

impl WholeMotion {
    pub(super) fn new(
        axes: Vec<Axis>,
        segments: Vec<Segment>,
        played: Played,
        last: Vec<i32>,
        (cycle_us, most_percent): (u32, u16),
    ) -> Self {
        Self {
            places: axes.iter().map(|axis| axis.place).collect(),
            axes,
            segments,
            played,
            last,
            cycle_us,
            most_percent,
            stand: Vec::new(),
            offered: 0,
        }
    }

    pub(super) fn drives(&self) -> Vec<DriveId> {
        self.axes.iter().map(|axis| axis.drive).collect()
    }
}

impl BoardMotion for WholeMotion {
    fn cycle_us(&self) -> u32 {
        self.cycle_us
    }

    fn cycles(&self) -> Option<u64> {
        Some(self.played.cycles)
    }

    fn most_percent(&self) -> u16 {
        self.most_percent
    }

    fn begin(&mut self, stream: u32, stand: &[i32]) -> Option<Begin> {
        self.stand = stand.to_vec();
        Some(begin(stream, stand))
    }

    fn feed(&mut self, client: &mut BoardClient) {
        let rest = self.segments.get(self.offered..);
        let mut source = rest
            .unwrap_or_default()
            .iter()
            .map(|segment| place(segment, &self.places, &self.stand))
            .inspect(|_| self.offered += 1);
        client.feed(&mut source);
    }
}
