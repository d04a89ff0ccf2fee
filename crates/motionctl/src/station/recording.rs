//! What a station tells a recorder: every cycle, frame and event, at the time of this computer.

use can_motion::{AxisSnapshot, Event, EventKind, Instant, ReadBackScale};

use super::pace::PaceCounts;
use super::pc_master::PcMaster;
use crate::link::Link;
use crate::recording::{
    AxisNaming, AxisSample, Kind, Recorded, Recorder, Sample, WheelReadings, WireFrame, servo_words,
};

/// A recorder behind a link, whatever the drives are.
pub(crate) struct BusRecorder {
    recorder: Recorder,
    start: std::time::Instant,
    bit_ns: u64,
    /// What is added to the time of the station.
    offset_us: u64,
    /// Least length of the frames since the last cycle.
    busy_ns: u64,
    cycle_at_us: u64,
    /// Late and missed cycles, and late set-points, until the last cycle.
    late: u64,
    motion_begins: bool,
}

/// What a cycle was.
pub(crate) struct CycleFacts {
    /// On the clock.
    pub(crate) number: u64,
    pub(crate) pace: PaceCounts,
    /// Cycles that the master could not hand over in time, until now.
    pub(crate) late_hand_overs: u32,
}

impl BusRecorder {
    /// Times count from `start`.
    pub(crate) const fn new(recorder: Recorder, start: std::time::Instant, bit_ns: u64) -> Self {
        Self {
            recorder,
            start,
            bit_ns,
            offset_us: 0,
            busy_ns: 0,
            cycle_at_us: 0,
            late: 0,
            motion_begins: false,
        }
    }

    /// The next cycle is the first of the motion.
    pub(crate) const fn motion_begins(&mut self) {
        self.motion_begins = true;
    }

    /// A phase of the run begins.
    pub(crate) fn phase(&mut self, text: &str) {
        let at_us = self.now_us();
        self.recorder.happened(at_us, None, Kind::Phase, text);
    }

    /// A stream names its axes.
    pub(crate) fn name_axes(&mut self, naming: Vec<AxisNaming>) {
        self.recorder.name_axes(naming);
    }

    /// The clock of the station shows `now`.
    pub(crate) fn agree_on_time(&mut self, now: Instant) {
        self.offset_us = self.now_us().saturating_sub(now.as_us());
    }

    /// An event of the master; `axis` is its place in the motion.
    pub(crate) fn happened(&mut self, at: Instant, axis: Option<usize>, kind: Kind, text: String) {
        let at_us = at.as_us().saturating_add(self.offset_us);
        self.recorder.happened(at_us, axis, kind, text);
    }

    /// A cycle with its axes, and with the readings of hub motors where the drives are such.
    pub(crate) fn cycle(
        &mut self,
        cycle: &CycleFacts,
        (axes, wheels): (Vec<AxisSample>, Vec<WheelReadings>),
        link: &mut Link,
    ) {
        self.frames(link);
        let at_us = self.now_us();
        if core::mem::take(&mut self.motion_begins) {
            self.recorder.motion_begins(at_us, cycle.number);
        }
        let late = cycle.pace.late + cycle.pace.merged + u64::from(cycle.late_hand_overs);
        let passed_ns = at_us.saturating_sub(self.cycle_at_us) * 1_000;
        self.recorder.cycle(Sample {
            at_us,
            number: cycle.number,
            load: (self.busy_ns as f64 / passed_ns.max(1) as f64).min(1.0),
            is_late: late > self.late,
            axes,
            wheels,
        });
        (self.busy_ns, self.cycle_at_us, self.late) = (0, at_us, late);
    }

    /// Takes the last frames, and closes every file.
    pub(crate) fn finish(mut self, link: &mut Link) -> Recorded {
        self.frames(link);
        self.recorder.finish()
    }

    fn frames(&mut self, link: &mut Link) {
        for passed in link.take_frames() {
            let Some(frame) = can_decode::Frame::from_can(&passed.frame) else {
                continue;
            };
            let since = passed.at.saturating_duration_since(self.start);
            let end_ns = u64::try_from(since.as_nanos()).unwrap_or(u64::MAX);
            let frame = WireFrame::ended(end_ns, frame, Some(passed.was_sent), self.bit_ns);
            self.busy_ns += u64::from(frame.bits) * self.bit_ns;
            self.recorder.frame(frame);
        }
    }

    fn now_us(&self) -> u64 {
        u64::try_from(self.start.elapsed().as_micros()).unwrap_or(u64::MAX)
    }
}

/// One axis of a recording.
struct Axis {
    /// Its place in the master.
    place: usize,
    read_back: ReadBackScale,
    /// When the position came that was recorded last.
    read_at: Option<Instant>,
}

/// A recorder that knows the axes of a station of servo drives.
pub(crate) struct StationRecorder {
    bus: BusRecorder,
    /// In the order of the motion's columns.
    axes: Vec<Axis>,
}

impl StationRecorder {
    /// `places` has the place in the master of each axis.
    pub(crate) fn new(bus: BusRecorder, places: &[usize], read_back: &[ReadBackScale]) -> Self {
        let axis = |(&place, &read_back): (&usize, &ReadBackScale)| Axis {
            place,
            read_back,
            read_at: None,
        };
        Self {
            bus,
            axes: places.iter().zip(read_back).map(axis).collect(),
        }
    }

    /// What is the same for all drives.
    pub(crate) const fn bus(&mut self) -> &mut BusRecorder {
        &mut self.bus
    }

    pub(super) fn event(&mut self, event: &Event<EventKind>) {
        let place = event.axis.map(usize::from);
        let axis = place.and_then(|place| self.axes.iter().position(|axis| axis.place == place));
        let (kind, text) = servo_words(event.kind);
        self.bus.happened(event.at, axis, kind, text);
    }

    pub(super) fn cycle(
        &mut self,
        now: Instant,
        number: u64,
        master: &PcMaster,
        link: &mut Link,
        pace: PaceCounts,
    ) {
        let axes = self.axes.iter_mut();
        let samples = axes.filter_map(|axis| Some(axis.sample(&master.snapshot(axis.place)?, now)));
        let samples = samples.collect();
        let cycle = CycleFacts {
            number,
            pace,
            late_hand_overs: master.cycle_counters().late,
        };
        self.bus.cycle(&cycle, (samples, Vec::new()), link);
    }

    /// Takes the last frames, and closes every file.
    pub(super) fn finish(self, link: &mut Link) -> Recorded {
        self.bus.finish(link)
    }
}

impl Axis {
    /// A position belongs to the cycle in which it came, and to no other.
    fn sample(&mut self, snapshot: &AxisSnapshot, now: Instant) -> AxisSample {
        let read = snapshot.feedback.position;
        let read_at = read.map(|read| read.at);
        let is_fresh = core::mem::replace(&mut self.read_at, read_at) != read_at;
        let fresh = read.filter(|_| is_fresh);
        let counts = fresh.and_then(|read| self.read_back.to_command_counts(read.value));
        AxisSample::new(snapshot, counts.map(i64::from), now)
    }
}
