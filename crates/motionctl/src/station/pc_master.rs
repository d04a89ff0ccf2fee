//! The master with its link and the clock: one cycle after the other.

use can_motion::plan::BusSetup;
use can_motion::{
    AxisConfig, AxisSnapshot, ConfigError, Event, EventKind, GroupId, Instant, MasterConfig,
    Progress, ServoMaster, Timeouts,
};
use dyn_can::DriveId;

use super::clock::{Clock, serve_until};
use super::pace::{Pace, PaceCounts};
use super::recording::StationRecorder;
use crate::counted::counted;
use crate::link::{ANSWER_LIMIT, Link, LinkFault};
use crate::output::tell;
use crate::recording::Recorded;

/// The master of this tool: room for every drive that a bus can carry.
pub(crate) type PcMaster = ServoMaster<63>;

/// All axes of this tool are in one group.
pub(crate) const GROUP: GroupId = GroupId(0);

/// In a longer cycle even 63 drives at 10 kbit/s fit.
const LONGEST_CYCLE_US: u32 = 640_000;

/// Without a set-point that gets out for so long the motion ends with an error. A PC that is busy pauses a program for some hundred
/// milliseconds, a firmware never.
pub(crate) const STUCK_US: u32 = 500_000;

/// Waiting times for a PC: adapters on USB hold bytes back for up to 16 ms, and the system lets a program wait.
const TIMEOUTS: Timeouts = Timeouts {
    reply_us: 100_000,
    confirm_us: 1_000_000,
    stuck_us: STUCK_US,
    lost_after: 5,
    ..Timeouts::DEFAULT
};

/// A master with its link.
pub(crate) struct Station<'link> {
    pub(super) master: PcMaster,
    pub(super) link: &'link mut Link,
    pub(super) clock: Clock,
    pub(super) pace: Pace,
    pub(super) config: MasterConfig,
    pub(super) axes: Vec<AxisConfig>,
    /// Drives that this station told to switch on, until they have confirmed that they are off.
    pub(super) switched_on: Vec<DriveId>,
    /// Drives that were on before.
    pub(super) found_on: Vec<DriveId>,
    /// Whoever used the station has the warning that the link has failed.
    pub(super) link_warning_is_given: bool,
    /// Whoever records what happens.
    recorder: Option<StationRecorder>,
}

impl<'link> Station<'link> {
    /// A master for these axes, in ascending order of drive id. Nothing is sent yet.
    ///
    /// # Errors
    /// When the configuration cannot work, or the bus cannot carry the axes in this cycle.
    pub(crate) fn new(
        link: &'link mut Link,
        axes: &[AxisConfig],
        cycle_us: u32,
    ) -> Result<Self, ConfigError> {
        let config = MasterConfig {
            cycle_us,
            timeouts: TIMEOUTS,
            bus: BusSetup {
                bit_rate: link.bit_rate(),
                ..BusSetup::DEFAULT
            },
            ..MasterConfig::DEFAULT
        };
        Ok(Self {
            master: PcMaster::new(config, axes)?,
            link,
            clock: Clock::start(),
            pace: Pace::new(cycle_us),
            config,
            axes: axes.to_vec(),
            switched_on: Vec::new(),
            found_on: Vec::new(),
            link_warning_is_given: false,
            recorder: None,
        })
    }

    /// The same with the shortest cycle, of at least so many microseconds, in which the bus carries the axes: for commands
    /// that stream no motion.
    ///
    /// # Errors
    /// When the configuration cannot work in any cycle.
    pub(crate) fn unhurried(
        link: &'link mut Link,
        axes: &[AxisConfig],
        at_least_us: u32,
    ) -> Result<Self, ConfigError> {
        let mut cycle_us = at_least_us;
        while let Err(ConfigError::Plan { .. }) = Station::new(link, axes, cycle_us)
            && cycle_us < LONGEST_CYCLE_US
        {
            cycle_us *= 2;
        }
        Self::new(link, axes, cycle_us)
    }

    /// The master, to read its state and to command it.
    pub(crate) fn master(&mut self) -> &mut PcMaster {
        &mut self.master
    }

    /// Every axis at this moment, in ascending order of drive id.
    pub(crate) fn snapshots(&self) -> impl Iterator<Item = AxisSnapshot> + '_ {
        (0..).map_while(|axis| self.master.snapshot(axis))
    }

    /// The drives, in the order of the axes.
    pub(crate) fn drives(&self) -> impl Iterator<Item = DriveId> + '_ {
        self.axes.iter().map(|axis| axis.drive)
    }

    /// How well the cycles kept their time.
    pub(crate) fn pace(&self) -> PaceCounts {
        self.pace.counts()
    }

    /// The present moment.
    pub(crate) fn now(&self) -> Instant {
        self.clock.now()
    }

    /// One cycle: serves the bus until it is due, lets `prepare` set targets, begins it. `prepare` gets the number of the
    /// cycle on the clock, which jumps over cycles that were missed.
    ///
    /// # Errors
    /// The fault of the link, after which nothing gets through any more.
    pub(crate) fn cycle(
        &mut self,
        prepare: impl FnOnce(&mut PcMaster, u64),
    ) -> Result<(), LinkFault> {
        serve_until(&mut self.master, self.link, &self.clock, self.pace.due())?;
        let now = self.clock.now();
        self.note_unknown(now);
        let number = self.pace.begin(now);
        prepare(&mut self.master, number);
        self.master.begin_cycle(now);
        let progress = can_motion::service(&mut self.master, self.link, now);
        if let Some(recorder) = &mut self.recorder {
            recorder.cycle(now, number, &self.master, self.link, self.pace.counts());
        }
        match (progress, self.link.fault()) {
            (_, Some(fault)) => Err(fault),
            (Progress::Idle | Progress::Blocked, None) => Ok(()),
        }
    }

    /// Frames of which nobody knows whether they went out: what was booked may be wrong, so every axis that has or wants power
    /// stops and anchors anew.
    fn note_unknown(&mut self, now: Instant) {
        let frames = self.link.take_unknown();
        let is_meant = |axis: AxisSnapshot| {
            axis.facts.goal != can_motion::facts::Goal::Off || axis.facts.moves()
        };
        if frames == 0 || !self.snapshots().any(is_meant) {
            return;
        }
        tell(format_args!(
            "the adapter did not answer for {} within {} ms: it is not known whether {} went out, so every axis stops",
            counted(frames, "frame", "frames"),
            ANSWER_LIMIT.as_millis(),
            if frames == 1 { "it" } else { "they" },
        ));
        self.master.on_bus_off(now);
        self.master.on_bus_recovered(now);
    }

    /// The oldest event that was not read yet.
    pub(crate) fn next_event(&mut self) -> Option<Event<EventKind>> {
        let event = self.master.next_event()?;
        if let Some(recorder) = &mut self.recorder {
            recorder.event(&event);
        }
        Some(event)
    }

    /// Lets somebody record every cycle, frame and event from now on. Frames that the link has kept until now are among them.
    pub(crate) fn record(&mut self, mut recorder: StationRecorder) {
        recorder.bus().agree_on_time(self.clock.now());
        self.recorder = Some(recorder);
    }

    /// The recorder, to note what the station does not know.
    pub(crate) fn recorder(&mut self) -> Option<&mut StationRecorder> {
        self.recorder.as_mut()
    }

    /// Ends the recording: after [`Self::shut_down`], because it waits for files.
    pub(crate) fn finish_recording(&mut self) -> Recorded {
        let recorder = self.recorder.take();
        recorder.map_or_else(Recorded::default, |recorder| recorder.finish(self.link))
    }
}
