//! Takes set-points and makes segments of them, as far ahead of the board as the sender may be.

use std::collections::VecDeque;

use board_link::host::{SegmentMaker, SegmentMakerConfig};
use board_link::segment::{MOST_AXES, Segment, SegmentPreview, StreamPhase};
use board_link::{Counters, Refusal};
use trajectory::{Position, Time};

use super::arguments::Buffering;
use super::columns::Columns;
use crate::board::motion::{GivenUp, StreamState};
use crate::set_points::{Order, Speed};
use crate::stream::{SetPointTaker, status};

/// Set-points of which nobody knows yet how close they are.
const FIRST_CREDIT: usize = 8;
/// Segments that wait for the client: more than the farthest sender may be ahead.
const MOST_WAITING: usize = 8_192;

/// What is the same for a whole stream.
pub(super) struct Setup {
    pub(super) cycle_us: u32,
    pub(super) buffering: Buffering,
    pub(super) maker: SegmentMakerConfig,
    pub(super) columns: Columns,
}

/// How the path ends.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum PathEnd {
    /// Not yet.
    Open,
    /// At rest, at the last set-point.
    AtRest,
    /// In motion: nothing may be made of it that comes to rest there.
    InMotion,
}

/// Set-points as segments.
pub(super) struct Taker {
    setup: Setup,
    /// Once the axes are enabled.
    maker: Option<SegmentMaker<MOST_AXES>>,
    /// Made, and not handed to the client.
    pub(super) segments: VecDeque<Segment>,
    pub(super) made: u32,
    counters: Counters,
    first: Option<Time>,
    /// The path is complete until then.
    complete: Time,
    pub(super) end: PathEnd,
    /// The sender went without an end.
    pub(super) is_gone: bool,
    /// Why the stream was told to stop from here.
    pub(super) given_up: Option<GivenUp>,
    /// The sender wants it to stop.
    is_stopping: bool,
    pub(super) orders: VecDeque<Order>,
    /// As the board said last.
    state: Option<StreamState>,
    /// At which the stream would begin.
    speed: Speed,
    /// Time of the last way in seconds, and what it takes, where that is longer.
    pub(super) slow_end: Option<(f64, f64)>,
    was_dry: bool,
}

impl Taker {
    pub(super) fn new(setup: Setup) -> Self {
        Self {
            setup,
            maker: None,
            segments: VecDeque::new(),
            made: 0,
            counters: Counters::default(),
            first: None,
            complete: Time::ZERO,
            end: PathEnd::Open,
            is_gone: false,
            given_up: None,
            is_stopping: false,
            orders: VecDeque::new(),
            state: None,
            speed: Speed {
                asked_percent: 100,
                actual_percent: 0.0,
                is_paused: false,
            },
            slow_end: None,
            was_dry: false,
        }
    }

    /// Takes set-points from now on, for axes that stand here; the stream will begin at this speed.
    pub(super) fn get_ready(&mut self, stand: &[i32], speed: Speed) {
        // Nothing moves yet.
        self.speed = Speed {
            actual_percent: 0.0,
            ..speed
        };
        if self.maker.is_some() {
            return;
        }
        let limits = self.setup.columns.stand_at(stand);
        let stand = self.setup.columns.stand();
        self.maker = SegmentPreview::new(&limits, stand)
            .and_then(|preview| SegmentMaker::new(preview, stand, self.setup.maker));
    }

    pub(super) const fn buffering(&self) -> &Buffering {
        &self.setup.buffering
    }

    pub(super) const fn cycle_us(&self) -> u32 {
        self.setup.cycle_us
    }

    /// Whether so much is there that the motion may begin.
    pub(super) fn has_lead(&self) -> bool {
        let lead = self.setup.buffering.lead;
        let has_enough = self.end != PathEnd::Open || self.until(self.complete) >= lead;
        has_enough && !self.is_stopping && self.given_up.is_none()
    }

    /// Whether the board waits for more: it begins, or goes on, when so much is there.
    fn lacks_lead(&self) -> bool {
        let waits = self.state.is_none_or(|state| {
            matches!(
                state.phase,
                StreamPhase::Idle | StreamPhase::Waiting | StreamPhase::Dry
            )
        });
        waits && self.until(self.complete) < self.setup.buffering.lead
    }

    /// Where the streamed axes are at the last set-point, in counts from the start.
    pub(super) fn targets(&self) -> Vec<i32> {
        let latest = self.maker.as_ref().and_then(SegmentMaker::latest);
        let positions = latest.map(|(_, positions)| positions);
        self.setup.columns.targets(positions)
    }

    /// Milliseconds from where the motion is to the last set-point.
    pub(super) fn buffered_ms(&self) -> f64 {
        f64::from(self.ahead().cycles()) * self.cycle_ms()
    }

    fn ahead(&self) -> Time {
        self.until(self.latest_time().max(self.complete))
    }

    /// From where the motion is.
    fn until(&self, time: Time) -> Time {
        let passed = self.state.map_or(0, |state| state.time_cycles);
        let now = self
            .first
            .map(|first| first.after(Time::from_cycles(passed)));
        time.since(now.unwrap_or(time))
    }

    fn latest_time(&self) -> Time {
        let latest = self.maker.as_ref().and_then(SegmentMaker::latest);
        latest.map_or(Time::ZERO, |(time, _)| time)
    }

    /// The board has said how it is; whether the set-points have just run out.
    pub(super) fn watch(&mut self, state: &StreamState) -> bool {
        self.state = Some(*state);
        let is_dry = match state.phase {
            StreamPhase::DriedUp => true,
            StreamPhase::Dry => !self.is_stopping,
            _ => false,
        };
        let has_run_dry = is_dry && !self.was_dry;
        self.was_dry = is_dry;
        if has_run_dry {
            self.counters.dry = self.counters.dry.saturating_add(1);
        }
        if is_dry && self.end == PathEnd::InMotion {
            // It would wait for ever.
            self.give_up(GivenUp::RanOut);
        }
        has_run_dry
    }

    fn give_up(&mut self, why: GivenUp) {
        if self.given_up.is_none() {
            self.given_up = Some(why);
            self.orders.push_back(Order::Stop);
        }
    }

    /// A sender of too many set-points is not played at all: what is left of them would be another path.
    fn check_density(&mut self, time: Time) {
        let first = self.maker.as_ref().and_then(SegmentMaker::first_for_memory);
        if first.is_some_and(|first| time < first) {
            let kept = self.setup.maker.kept;
            let most_ms = f64::from(self.setup.maker.least_kept.cycles()) * self.cycle_ms();
            let per_second = (kept as f64 * 1e3 / most_ms).floor();
            self.give_up(GivenUp::Unplayable(format!(
                "the sender writes more set-points than the memory of the board holds: expected {kept} of them in at least {most_ms:.0} ms, which are {per_second} a second; write fewer, the curve between them is smooth"
            )));
        }
    }

    fn cycle_ms(&self) -> f64 {
        f64::from(self.setup.cycle_us) * 1e-3
    }

    fn is_late(&self) -> bool {
        let phase = self.state.map(|state| state.phase);
        phase == Some(StreamPhase::DriedUp)
    }

    fn add(&mut self, segment: Segment) {
        self.complete = self.complete.after(segment.time());
        self.segments.push_back(segment);
        self.made += 1;
    }

    /// The last one, which may take longer than its set-points say.
    fn add_last(&mut self, segment: Segment) {
        let gap = self.latest_time().since(self.complete);
        if segment.time() > gap {
            let seconds = |time: Time| time.cycles() as f64 * self.cycle_ms() * 1e-3;
            self.slow_end = Some((seconds(gap), seconds(segment.time())));
        }
        self.add(segment);
    }

    /// A path that ends in motion before the board would begin it is not played: it would wait for more, for ever.
    fn check_length(&mut self, refusal: Refusal) {
        let waits = self
            .state
            .is_none_or(|state| matches!(state.phase, StreamPhase::Idle | StreamPhase::Waiting));
        if waits && self.until(self.complete) < self.setup.maker.least_kept {
            let refusal = self.setup.columns.of_sender(refusal);
            self.give_up(GivenUp::Unplayable(format!(
                "the set-points end before the motion begins, and too fast to come to rest at the last one ({refusal}): nothing was moved; let them slow down"
            )));
        }
    }

    fn take(&mut self, time: Time, positions: &[Position]) -> Result<(), Refusal> {
        if self.is_late() {
            let expected = self.latest_time();
            let actual = time;
            return Err(Refusal::Late { expected, actual });
        }
        if self.is_stopping || self.given_up.is_some() {
            return Err(Refusal::Ended);
        }
        let all = self.setup.columns.among_all(positions);
        // Nothing is read before the axes are enabled.
        let maker = self.maker.as_mut().ok_or(Refusal::Ended)?;
        let made = maker.push(time, &all);
        let segment = made.map_err(|refusal| {
            if matches!(refusal, Refusal::Close { .. }) {
                self.check_density(time);
            }
            self.setup.columns.of_sender(refusal)
        })?;
        if self.first.is_none() {
            (self.first, self.complete) = (Some(time), time);
        }
        if let Some(segment) = segment {
            self.add(segment);
        }
        Ok(())
    }
}

impl SetPointTaker for Taker {
    fn is_open(&self) -> bool {
        let has_ended = self.is_stopping || self.is_late() || self.given_up.is_some();
        self.end == PathEnd::Open && !has_ended
    }

    fn credit(&self) -> usize {
        if !self.is_open() {
            return 0;
        }
        let taken = self.counters.taken as usize;
        let spacing = self.maker.as_ref().and_then(SegmentMaker::spacing);
        let (Some(spacing), true) = (spacing, taken >= FIRST_CREDIT) else {
            return FIRST_CREDIT.saturating_sub(taken);
        };
        let room = self.setup.buffering.ahead.since(self.ahead());
        let finished = self.state.map_or(0, |state| state.finished) as usize;
        // Two more are always needed to go on, however far apart they are.
        let least = 3_usize.saturating_sub(taken.saturating_sub(finished + 1));
        // The path is complete one set-point before the last: with a lead of about `ahead` it would never be long enough.
        let least = least.max(usize::from(self.lacks_lead()));
        let fitting = (room.ticks() / spacing.ticks().max(1)) as usize;
        let free = MOST_WAITING.saturating_sub(self.segments.len());
        free.min(fitting.max(least))
    }

    fn push(&mut self, time: Time, positions: &[Position]) -> Result<(), Refusal> {
        let taken = self.take(time, positions);
        self.counters.count(&taken);
        taken
    }

    fn end(&mut self, is_gone: bool) {
        if self.end != PathEnd::Open {
            return;
        }
        self.is_gone = is_gone;
        let finished = self.maker.as_mut().map_or(Ok(None), SegmentMaker::finish);
        self.end = match finished {
            Ok(segment) => {
                segment
                    .into_iter()
                    .for_each(|segment| self.add_last(segment));
                PathEnd::AtRest
            }
            Err(refusal) => {
                self.check_length(refusal);
                PathEnd::InMotion
            }
        };
    }

    fn order(&mut self, order: Order) {
        self.is_stopping |= order == Order::Stop;
        self.orders.push_back(order);
    }

    fn status(&self) -> String {
        let (phase, speed) = self
            .state
            .map_or((StreamPhase::Waiting, self.speed), |state| {
                (state.phase, state.speed)
            });
        status(phase, speed, self.buffered_ms())
    }

    fn counters(&self) -> Counters {
        self.counters
    }
}
