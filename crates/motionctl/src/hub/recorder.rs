//! What a station of wheels tells a recorder.

use can_motion::wheel::{WheelEventKind, WheelSnapshot};
use can_motion::{Event, Instant};

use crate::link::Link;
use crate::recording::{AxisSample, Recorded, WheelReadings, wheel_words};
use crate::station::{BusRecorder, CycleFacts};

/// One wheel of a recording.
#[derive(Debug, Clone, Copy)]
pub(super) struct RecordedWheel {
    /// Its place in the master.
    pub(super) place: usize,
    /// Speeds count 1/n r/min.
    pub(super) speed_resolution: u16,
}

/// A recorder that knows the wheels of a station.
pub(super) struct WheelRecorder {
    bus: BusRecorder,
    /// In the order of the columns, with the time of the speed that was recorded last.
    wheels: Vec<(RecordedWheel, Option<Instant>)>,
}

impl WheelRecorder {
    /// Wheels in the order of the columns.
    pub(super) fn new(bus: BusRecorder, wheels: impl Iterator<Item = RecordedWheel>) -> Self {
        Self {
            bus,
            wheels: wheels.map(|wheel| (wheel, None)).collect(),
        }
    }

    /// What is the same for all drives.
    pub(super) const fn bus(&mut self) -> &mut BusRecorder {
        &mut self.bus
    }

    pub(super) fn event(&mut self, event: &Event<WheelEventKind>) {
        let place = event.axis.map(usize::from);
        let is_it = |place| move |(wheel, _): &(RecordedWheel, _)| wheel.place == place;
        let axis = place.and_then(|place| self.wheels.iter().position(is_it(place)));
        let (kind, text) = wheel_words(event.kind);
        self.bus.happened(event.at, axis, kind, text);
    }

    /// A cycle; the snapshots are in the order of the master.
    pub(super) fn cycle(
        &mut self,
        now: Instant,
        cycle: &CycleFacts,
        snapshots: &[WheelSnapshot],
        link: &mut Link,
    ) {
        let wheels = self.wheels.iter_mut();
        let samples = wheels.filter_map(|(wheel, read_at)| {
            let snapshot = snapshots.get(wheel.place)?;
            let read = snapshot.feedback.speed_decirpm;
            let came_at = read.map(|read| read.at);
            // A speed belongs to the cycle in which it came, and to no other.
            let is_fresh = core::mem::replace(read_at, came_at) != came_at;
            let speed_rpm = read.filter(|_| is_fresh);
            let speed_rpm = speed_rpm.map(|read| f64::from(read.value) / 10.0);
            Some((
                AxisSample::of_wheel(snapshot, wheel.speed_resolution, speed_rpm, now),
                WheelReadings::new(&snapshot.feedback, None),
            ))
        });
        let samples = samples.unzip();
        self.bus.cycle(cycle, samples, link);
    }

    /// Takes the last frames, and closes every file.
    pub(super) fn finish(self, link: &mut Link) -> Recorded {
        self.bus.finish(link)
    }
}
