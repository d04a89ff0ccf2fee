//! One axis: its facts, and what a change of them means to its drive.

use bus_user::Instant;

use crate::core::calendar::Due;
use crate::core::event::{CommonEvent, EventLog};
use crate::core::facts::{Facts, Knowledge, Motion, Power, Work};
use crate::core::family::{CommonFault, Context, Drive, Family, PowerReport, View};
use crate::core::stamp::Stamp;
use crate::core::state::{AxisState, Reason, Stage};
use crate::core::step::Input;

/// What changes an axis.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Change<F: Family> {
    pub(crate) input: Input,
    /// The fault, where the input is one.
    pub(crate) fault: Option<F::Fault>,
    /// The cycles of a ramp that the change may begin.
    pub(crate) ramp_cycles: u32,
}

impl<F: Family> Change<F> {
    /// A change that is no fault and begins no ramp.
    pub(crate) const fn of(input: Input) -> Self {
        Self {
            input,
            fault: None,
            ramp_cycles: 0,
        }
    }

    /// The fault that this change shows when it latches one.
    fn cause(&self) -> F::Fault {
        self.fault.unwrap_or(match self.input {
            Input::SaysOff => CommonFault::SwitchedOff.into(),
            Input::SaysOn => CommonFault::SwitchedOn.into(),
            _ => CommonFault::NotConfirmed.into(),
        })
    }
}

/// An axis of the master.
#[derive(Debug)]
pub(crate) struct Axis<F: Family> {
    /// Where it is, as its drive is told.
    pub(crate) view: View,
    /// What the latch of its own is for.
    cause: Option<F::Fault>,
    /// When the controller accepted the latest switch.
    pub(crate) switched_at: Stamp,
    /// When the controller accepted the latest frame of a cycle in motion, or motion began.
    pub(crate) sent_at: Stamp,
    /// When its request is due.
    pub(crate) asks: Due,
    /// How often the present disable command was repeated.
    repeated: u16,
    pub(crate) drive: F::Drive,
}

impl<F: Family> Axis<F> {
    pub(crate) fn new(drive: F::Drive) -> Self {
        Self {
            view: View::new(
                Facts::start(drive.brake()),
                Stage::PowerOn,
                Instant::default(),
            ),
            cause: None,
            switched_at: Stamp::default(),
            sent_at: Stamp::default(),
            asks: Due::NEW,
            repeated: 0,
            drive,
        }
    }

    pub(crate) const fn state(&self) -> AxisState {
        AxisState::of(&self.view.facts, self.view.stage)
    }

    /// The latched fault.
    pub(crate) fn fault(&self) -> Option<F::Fault> {
        use crate::core::facts::Latch;
        match self.view.facts.latch {
            Latch::None => None,
            Latch::Group => Some(CommonFault::Group.into()),
            Latch::Own => self.cause,
        }
    }

    #[inline(always)]
    pub(crate) fn snapshot(&self, now: Instant) -> F::Snapshot {
        self.drive
            .snapshot(now, self.state(), &self.view.facts, self.fault())
    }

    /// Works out anew when its request is due.
    pub(crate) fn look_ahead(&mut self, now: Instant, cycle: u32) {
        let outlook = self.drive.outlook(&self.view, now, cycle);
        self.asks = Due::new(outlook, now, cycle);
    }

    /// As [`Stamp::keep`], for all that the axis has.
    pub(crate) fn keep_stamps(&mut self, now: Instant, is_long_ago: bool) {
        self.view.since.keep(now, is_long_ago);
        self.switched_at.keep(now, is_long_ago);
        self.sent_at.keep(now, is_long_ago);
        self.drive.keep_stamps(now, is_long_ago);
    }

    /// Lets a cycle pass in which the axis only streams; false, with nothing done, when there is more to do.
    #[inline]
    pub(crate) fn streams_on(&mut self, now: Instant, stuck_us: u32) -> bool {
        self.view.facts.streams()
            && !self.sent_at.has_lasted(now, stuck_us)
            && self.drive.streams_on(now)
    }

    /// Calls the drive with what it needs.
    pub(crate) fn with_drive<R>(
        &mut self,
        config: &F::Config,
        cycle: u32,
        log: EventLog<'_, F::EventKind>,
        call: impl FnOnce(&mut F::Drive, &mut Context<'_, F>) -> R,
    ) -> R {
        let mut context = Context {
            config,
            view: &self.view,
            cycle,
            log,
        };
        call(&mut self.drive, &mut context)
    }

    /// The checks go on at another stage.
    pub(crate) fn set_stage(&mut self, stage: Stage, log: &mut EventLog<'_, F::EventKind>) {
        if self.view.stage == stage {
            return;
        }
        let from = self.state();
        self.view.stage = stage;
        self.view.since = Stamp::of(log.now);
        self.report(from, Reason::Reading, log);
    }

    /// Whether a fault would change nothing that matters: the axis has one, and nothing is left to take from it.
    pub(crate) fn has_lost_already(&self, after: &Facts) -> bool {
        let matters = |facts: &Facts| {
            let power = (matches!(facts.power, Power::On), facts.power.may_be_on());
            (
                facts.latch,
                facts.knowledge,
                facts.motion,
                facts.goal,
                power,
            )
        };
        matters(after) == matters(&self.view.facts)
    }

    /// Takes over new facts, with everything that follows from them for this axis.
    pub(crate) fn become_(
        &mut self,
        after: Facts,
        change: &Change<F>,
        log: &mut EventLog<'_, F::EventKind>,
    ) {
        let (before, from) = (self.view.facts, self.state());
        self.view.facts = after;
        self.note_fault(change, log);
        self.note_power(before, after, log);
        self.note_motion(before, after, change, log.now);
        if before.work != Work::None && after.work == Work::None && change.input != Input::WorkEnded
        {
            self.drive.abort_work(log);
        }
        let is_progress = after.knowledge > before.knowledge
            || after.power != before.power
            || after.goal != before.goal
            || (after.moves() && !before.moves());
        if is_progress {
            self.view.since = Stamp::of(log.now);
        }
        let starts_over = after.is_checking()
            && (before.knowledge != Knowledge::Unknown || change.input == Input::Clear);
        if starts_over {
            let is_cleared = change.input == Input::Clear;
            self.view.stage = self.drive.start_over(log.now, is_cleared);
            self.view.since = Stamp::of(log.now);
            self.view.is_lost = false;
        }
        self.report(from, Reason::of(change.input), log);
    }

    fn note_fault(&mut self, change: &Change<F>, log: &mut EventLog<'_, F::EventKind>) {
        use crate::core::facts::Latch;
        let is_fault = match self.view.facts.latch {
            Latch::Own => self.cause.is_none() || matches!(change.input, Input::Fault { .. }),
            Latch::Group | Latch::None => {
                self.cause = None;
                false
            }
        };
        if is_fault {
            let cause = change.cause();
            log.push(CommonEvent::Fault(cause));
            self.cause = self.cause.or(Some(cause));
        } else if matches!(change.input, Input::GroupFault { .. })
            && self.view.facts.latch == Latch::Group
        {
            log.push(CommonEvent::Fault(F::Fault::from(CommonFault::Group)));
        }
    }

    /// Whether a report on the power was asked for before the latest switch counts as sent. The controller may hold a command for a
    /// while, and one that sorts its frames may send a later reading before it.
    pub(crate) fn is_before_switch(
        &self,
        now: Instant,
        cycle_us: u32,
        report: PowerReport,
    ) -> bool {
        let is_sent = matches!(self.view.facts.power, Power::OnSent | Power::OffSent);
        is_sent && report.asked_at < self.switched_at.at(now) + cycle_us
    }

    /// The drive does not answer any more, or answers again.
    pub(crate) fn set_lost(&mut self, is_lost: bool) {
        self.view.is_lost = is_lost;
    }

    fn note_power(&mut self, before: Facts, after: Facts, log: &mut EventLog<'_, F::EventKind>) {
        if after.power == before.power {
            return;
        }
        match (before.power, after.power) {
            (Power::OffSent, Power::OffWanted) => self.note_unconfirmed(log),
            (_, Power::OnSent | Power::OffSent) => self.switched_at = Stamp::of(log.now),
            (_, Power::FoundOn) => log.push(CommonEvent::FoundOn),
            (_, Power::OffWanted | Power::Off) => {
                self.repeated = 0;
                self.switched_at = Stamp::of(log.now);
            }
            _ => {}
        }
    }

    /// The time of a disable command is over: nothing confirmed it, or it could not be sent.
    pub(crate) fn note_unconfirmed(&mut self, log: &mut EventLog<'_, F::EventKind>) {
        self.switched_at = Stamp::of(log.now);
        self.repeated = self.repeated.saturating_add(1);
        if self.repeated.is_power_of_two() {
            log.push(CommonEvent::DisableUnconfirmed {
                repeated: self.repeated.into(),
            });
        }
    }

    fn note_motion(&mut self, before: Facts, after: Facts, change: &Change<F>, now: Instant) {
        match (before.motion, after.motion) {
            (Motion::Rest, Motion::Stream) => {
                self.drive.begin_motion();
                self.sent_at = Stamp::of(now);
            }
            (Motion::Stream, Motion::Ramp) => {
                let common = change.ramp_cycles;
                let fits = self.drive.can_stop_in(common);
                self.drive.begin_ramp(if fits {
                    common
                } else {
                    self.drive.cycles_to_stop()
                });
            }
            (Motion::Stream | Motion::Ramp, Motion::Rest) => {
                self.drive.end_motion(change.input == Input::RampDone);
            }
            _ => {}
        }
        if F::MAKES_MOVES && before.has_own_move() && !after.has_own_move() {
            let how = match change.input {
                Input::MoveEnded(end) => Some(end),
                _ => None,
            };
            self.drive.end_move(now, how);
        }
    }

    fn report(&mut self, from: AxisState, reason: Reason, log: &mut EventLog<'_, F::EventKind>) {
        let to = self.state();
        if from != to {
            log.push(CommonEvent::State { from, to, reason });
        }
    }
}
