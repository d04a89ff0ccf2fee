//! The master of wheels on this computer: with its link and the clock, one cycle after the other.
//!
//! What a station enables it switches off again, whatever happens: at its end, after an error, after a panic. A program that is killed
//! leaves the drives to their own supervision (2000h).

use can_motion::wheel::{
    FeedbackTiming, WheelConfig, WheelEventKind, WheelFault, WheelMaster, WheelMasterConfig,
    WheelSnapshot, WheelTimeouts,
};
use can_motion::{AxisState, Confirmation, Event, GroupId, Instant};
use zlac8030l::{NodeId, ObjectAddress, SdoEnd, SdoEvent, SdoRequest, SdoTimeouts};

use super::error::HubError;
use super::nodes::named;
use super::recorder::WheelRecorder;
use crate::interrupt;
use crate::link::{Link, LinkFault};
use crate::output::tell;
use crate::recording::Recorded;
use crate::station::{Clock, CycleFacts, Pace, PaceCounts, serve_until};

/// Wheels that a station can hold.
pub(super) const MOST_WHEELS: usize = 16;
/// 20 ms as the guide counts ticks, 40 ms as CiA 301 does (Z11); a PC is no more regular than that.
const FEEDBACK_TICKS: u16 = 40;
/// Bit 0 X0, bit 1 X1.
const INPUT_LEVELS: ObjectAddress = ObjectAddress::new(0x2003, 0);
/// All wheels of this tool are in one group.
const GROUP: GroupId = GroupId(0);
/// Time for the wheels to become ready, and again to be enabled.
const BRING_UP_LIMIT_US: u64 = 10_000_000;
/// Time to slow down.
const RAMP_LIMIT_US: u64 = 10_000_000;
/// Time for the drives to confirm that they are off; the command is repeated meanwhile.
const CONFIRM_LIMIT_US: u64 = 5_000_000;

/// Waiting times for a PC: adapters on USB hold bytes back for up to 16 ms, and the system lets a program wait.
const TIMEOUTS: WheelTimeouts = WheelTimeouts {
    sdo: SdoTimeouts {
        reply_us: 100_000,
        ..SdoTimeouts::DEFAULT
    },
    heartbeat_lost_us: 1_000_000,
    feedback_lost_us: 500_000,
    offline_ms: 500,
    confirm_us: 1_000_000,
    stuck_us: 500_000,
    lost_after: 5,
    ..WheelTimeouts::DEFAULT
};

/// How the wheels end.
#[derive(Debug, Clone, Default, PartialEq, Eq)]
pub(super) struct WheelsEnd {
    /// Switched on by this station, and confirmed off.
    pub(super) disabled: Vec<NodeId>,
    /// Switched on by this station, and not confirmed off.
    pub(super) unconfirmed: Vec<NodeId>,
}

/// A master with its link.
pub(super) struct WheelStation<'link> {
    master: WheelMaster<MOST_WHEELS>,
    link: &'link mut Link,
    clock: Clock,
    pace: Pace,
    nodes: Vec<NodeId>,
    recorder: Option<WheelRecorder>,
    /// Power may be on by a command of this station.
    is_switched_on: bool,
    /// 2003h, by [`Self::ask_inputs`].
    inputs: Option<(u16, Instant)>,
}

impl<'link> WheelStation<'link> {
    /// A master for these wheels, in ascending order of node. Nothing is sent yet.
    ///
    /// # Errors
    /// [`HubError::Config`] when the configuration cannot work, or the bus cannot carry the wheels in this cycle.
    pub(super) fn new(
        link: &'link mut Link,
        wheels: &[WheelConfig],
        cycle_us: u32,
    ) -> Result<Self, HubError> {
        Self::with_feedback(link, wheels, cycle_us, FEEDBACK_TICKS)
    }

    /// Whether [`Self::new`] would make one.
    ///
    /// # Errors
    /// As [`Self::new`].
    pub(super) fn check(
        link: &Link,
        wheels: &[WheelConfig],
        cycle_us: u32,
    ) -> Result<(), HubError> {
        master(link, wheels, cycle_us, FEEDBACK_TICKS).map(|_| ())
    }

    /// As [`Self::new`], with feedback in so many ticks of the drives' timers.
    ///
    /// # Errors
    /// As [`Self::new`].
    pub(super) fn with_feedback(
        link: &'link mut Link,
        wheels: &[WheelConfig],
        cycle_us: u32,
        ticks: u16,
    ) -> Result<Self, HubError> {
        Ok(Self {
            master: master(link, wheels, cycle_us, ticks)?,
            link,
            clock: Clock::start(),
            pace: Pace::new(cycle_us),
            nodes: wheels.iter().map(|wheel| wheel.node).collect(),
            recorder: None,
            is_switched_on: false,
            inputs: None,
        })
    }

    /// The present moment.
    pub(super) fn now(&self) -> Instant {
        self.clock.now()
    }

    /// How well the cycles kept their time.
    pub(super) fn pace(&self) -> PaceCounts {
        self.pace.counts()
    }

    /// Every wheel at this moment, in ascending order of node.
    pub(super) fn snapshots(&self) -> impl Iterator<Item = WheelSnapshot> + '_ {
        (0..).map_while(|wheel| self.master.snapshot(wheel))
    }

    /// One cycle: serves the bus until it is due, lets `prepare` set targets, begins it.
    ///
    /// # Errors
    /// The fault of the link, after which nothing gets through any more.
    pub(super) fn cycle(
        &mut self,
        prepare: impl FnOnce(&mut WheelMaster<MOST_WHEELS>, u64),
    ) -> Result<(), LinkFault> {
        serve_until(&mut self.master, self.link, &self.clock, self.pace.due())?;
        let now = self.clock.now();
        if self.link.take_unknown() > 0 {
            // Targets are absolute and every cycle repeats them: what was lost is made good by the next frame.
            tell("the adapter did not answer for a frame in time; the next cycle repeats it");
        }
        let number = self.pace.begin(now);
        prepare(&mut self.master, number);
        self.master.begin_cycle(now);
        let _ = can_motion::service(&mut self.master, self.link, now);
        self.record_cycle(now, number);
        self.link.fault().map_or(Ok(()), Err)
    }

    /// Waits until every wheel is set up, enables them, and waits until all take targets.
    ///
    /// # Errors
    /// [`HubError`]; what was enabled until then is switched off by [`Self::shut_down`].
    pub(super) fn bring_up(&mut self) -> Result<(), HubError> {
        self.wait_until(AxisState::Ready)?;
        // Noted before the word is given: whatever happens from here on, these are switched off.
        self.is_switched_on = true;
        let now = self.now();
        if self.master.enable(now, GROUP).is_err() {
            let waiting = self
                .snapshots()
                .find(|wheel| wheel.state != AxisState::Ready);
            return Err(match waiting {
                Some(wheel) => HubError::NotReady {
                    node: wheel.node,
                    state: wheel.state.to_string(),
                },
                None => HubError::NothingGetsOut,
            });
        }
        self.wait_until(AxisState::Streaming)
    }

    fn wait_until(&mut self, state: AxisState) -> Result<(), HubError> {
        let start = self.now();
        loop {
            self.cycle(|_, _| {})?;
            if let Some((node, fault)) = self.first_fault() {
                return Err(HubError::WheelFault { node, fault });
            }
            let mut others = self.snapshots().filter(|wheel| wheel.state != state);
            let Some(wheel) = others.next() else {
                return Ok(());
            };
            let (node, wheel_state) = (wheel.node, wheel.state);
            drop(others);
            if wheel_state == AxisState::FoundOn {
                return Err(HubError::Enabled { node });
            }
            if interrupt::requests() > 0 {
                return Err(HubError::Interrupted);
            }
            if self.now().us_since(start) >= BRING_UP_LIMIT_US {
                let state = wheel_state.to_string();
                return Err(HubError::NotReady { node, state });
            }
        }
    }

    /// The first fault since the last time, of the wheel that is its cause.
    pub(super) fn first_fault(&mut self) -> Option<(NodeId, WheelFault)> {
        let mut first = None;
        while let Some(event) = self.next_event() {
            if let (WheelEventKind::Fault(fault), Some(axis)) = (event.kind, event.axis)
                && fault != WheelFault::Group
                && let Some(node) = self.nodes.get(usize::from(axis))
            {
                first = first.or(Some((*node, fault)));
            }
        }
        first
    }

    fn next_event(&mut self) -> Option<Event<WheelEventKind>> {
        let event = self.master.next_event()?;
        if let Some(recorder) = &mut self.recorder {
            recorder.event(&event);
        }
        if let WheelEventKind::Transfer(SdoEvent {
            request,
            end: SdoEnd::Value(data),
        }) = event.kind
            && request.address() == INPUT_LEVELS
        {
            // 16 bits of the reply are the object.
            self.inputs = Some((data.raw() as u16, event.at));
        }
        Some(event)
    }

    /// Lets somebody record every cycle, frame and event from now on. Frames that the link has kept until now are among them.
    pub(super) fn record(&mut self, mut recorder: WheelRecorder) {
        recorder.bus().agree_on_time(self.clock.now());
        self.recorder = Some(recorder);
    }

    /// The recorder, to note what the station does not know.
    pub(super) const fn recorder(&mut self) -> Option<&mut WheelRecorder> {
        self.recorder.as_mut()
    }

    fn record_cycle(&mut self, now: Instant, number: u64) {
        let Some(recorder) = &mut self.recorder else {
            return;
        };
        let wheels = (0..).map_while(|wheel| self.master.snapshot(wheel));
        let wheels: Vec<WheelSnapshot> = wheels.collect();
        let cycle = CycleFacts {
            number,
            pace: self.pace.counts(),
            late_hand_overs: self.master.cycle_counters().late,
        };
        recorder.cycle(now, &cycle, &wheels, self.link);
    }

    /// Ends the recording: after [`Self::shut_down`], because it waits for files.
    pub(super) fn finish_recording(&mut self) -> Recorded {
        // The last events: nobody reads them any more.
        while self.next_event().is_some() {}
        let recorder = self.recorder.take();
        recorder.map_or_else(Recorded::default, |recorder| recorder.finish(self.link))
    }

    /// Asks the first wheel for the levels of its inputs, unless it still owes an answer.
    pub(super) fn ask_inputs(&mut self) {
        let now = self.now();
        let read = SdoRequest::Read(INPUT_LEVELS);
        // Refused while another transfer waits: the next cycle asks again.
        let _ = self.master.start(now, 0, read, Confirmation::None);
    }

    /// What was read of them last, and when it came.
    pub(super) const fn input_levels(&self) -> Option<(u16, Instant)> {
        self.inputs
    }

    /// Slows the wheels down, in proportion; they hold then. Ctrl-C meanwhile stops them at once.
    ///
    /// # Errors
    /// The fault of the link.
    pub(super) fn come_to_rest(&mut self) -> Result<(), LinkFault> {
        let (start, requests) = (self.now(), interrupt::requests());
        self.master.stop(start, GROUP);
        while self.snapshots().any(|wheel| wheel.facts.moves())
            && self.now().us_since(start) < RAMP_LIMIT_US
        {
            self.cycle(|_, _| {})?;
            if interrupt::requests() > requests {
                break;
            }
        }
        let now = self.now();
        self.master.halt(now, GROUP);
        Ok(())
    }

    /// Slows the wheels down, switches them off and waits for their confirmation.
    ///
    /// # Errors
    /// The fault of the link, after which nothing gets through any more.
    pub(super) fn shut_down(&mut self) -> Result<WheelsEnd, LinkFault> {
        if !self.is_switched_on {
            return Ok(WheelsEnd::default());
        }
        self.come_to_rest()?;
        let unconfirmed = self.switch_off()?;
        self.is_switched_on = false;
        let is_off = |node: &&NodeId| !unconfirmed.contains(node);
        Ok(WheelsEnd {
            disabled: self.nodes.iter().filter(is_off).copied().collect(),
            unconfirmed,
        })
    }

    fn switch_off(&mut self) -> Result<Vec<NodeId>, LinkFault> {
        let start = self.now();
        self.master.disable(start, GROUP);
        loop {
            self.cycle(|_, _| {})?;
            let on: Vec<NodeId> = self
                .snapshots()
                .filter(|wheel| wheel.facts.power.may_be_on())
                .map(|wheel| wheel.node)
                .collect();
            if on.is_empty() || self.now().us_since(start) >= CONFIRM_LIMIT_US {
                return Ok(on);
            }
        }
    }

    /// The end of everything that enables: what came of it, and what became of the power of the drives.
    ///
    /// # Errors
    /// What went wrong in `moved` or afterwards, with the drives that may have power.
    pub(super) fn end<T>(
        &mut self,
        moved: Result<T, HubError>,
    ) -> Result<(T, WheelsEnd), HubError> {
        let end = match self.shut_down() {
            Ok(end) => end,
            Err(fault) => {
                self.is_switched_on = false;
                return Err(HubError::LinkWhileEnabled {
                    fault,
                    nodes: self.nodes.clone(),
                });
            }
        };
        if moved.is_err() && !end.disabled.is_empty() {
            // After an error nobody prints the end of a motion.
            tell(format_args!("disabled again: {}", named(&end.disabled)));
        }
        if end.unconfirmed.is_empty() {
            return moved.map(|moved| (moved, end));
        }
        Err(HubError::StillEnabled {
            nodes: end.unconfirmed,
            after: moved.err().map(Box::new),
        })
    }
}

fn master(
    link: &Link,
    wheels: &[WheelConfig],
    cycle_us: u32,
    ticks: u16,
) -> Result<WheelMaster<MOST_WHEELS>, HubError> {
    let config = WheelMasterConfig {
        cycle_us,
        bit_rate: link.bit_rate(),
        feedback: FeedbackTiming::Timer { ticks },
        timeouts: TIMEOUTS,
        ..WheelMasterConfig::DEFAULT
    };
    WheelMaster::new(config, wheels).map_err(HubError::Config)
}

impl Drop for WheelStation<'_> {
    /// Nobody called [`WheelStation::shut_down`], or it did not get to its end: an error half-way, or a panic.
    fn drop(&mut self) {
        if !core::mem::take(&mut self.is_switched_on) {
            return;
        }
        match self.switch_off() {
            Ok(unconfirmed) if unconfirmed.is_empty() => {
                tell(format_args!("disabled: {}", named(&self.nodes)));
            }
            Ok(nodes) => tell(HubError::StillEnabled { nodes, after: None }),
            Err(fault) => tell(HubError::LinkWhileEnabled {
                fault,
                nodes: self.nodes.clone(),
            }),
        }
    }
}
