//! One DYN drive: its frames, its readings, its ledger, and the one request that it may owe.

use bus_plan::ResponseWindow;
use bus_user::Instant;
use can_frame::wire::exact_bits;
use dyn_can::{DataFrame, Dialect, PdStep, Request, ServoSwitch, go_relative_pos_pd};

use crate::core::drive_move::{DriveMove, MoveEnd, MoveRefusal};
use crate::core::facts::{Facts, Work};
use crate::core::family::{
    Context, Drive, GroupId, Meaning, OutOfTravel, Outlook, Reaction, Returned, View, Wanted,
};
use crate::core::procedure::Confirmation;
use crate::core::snapshot::Counters;
use crate::core::stamp::Stamp;
use crate::core::state::{AxisState, Stage};
use crate::servo::ask::Ask;
use crate::servo::books::Procedures;
use crate::servo::config::{AxisConfig, MasterConfig};
use crate::servo::drift::DriftWatch;
use crate::servo::dyn_family::Dyn;
use crate::servo::event::Log;
use crate::servo::fault::Fault;
use crate::servo::latest::Latest;
use crate::servo::ledger::Ledger;
use crate::servo::own_move::concerns_own_move;
use crate::servo::poll_kind::PollKind;
use crate::servo::polls::PollClock;
use crate::servo::procedure::{Procedure, ProcedureError};
use crate::servo::request_slot::RequestSlot;
use crate::servo::response_watch::ResponseWatch;
use crate::servo::settings::Settings;
use crate::servo::snapshot::AxisSnapshot;

/// A DYN drive.
#[derive(Debug)]
pub struct Servo {
    pub(super) config: Settings,
    pub(super) dialect: Dialect,
    pub(super) ledger: Ledger,
    pub(super) drift: DriftWatch,
    pub(super) feedback: Latest,
    pub(super) counters: Counters,
    pub(super) slot: RequestSlot,
    pub(super) polls: PollClock,
    /// Length of the request of each poll on the wire.
    poll_bits: [u8; PollKind::ALL.len()],
    pub(super) responses: ResponseWatch,
    pub(super) timeouts_in_row: u8,
    /// When a drive that does not answer is asked again.
    pub(super) retry_at: Stamp,
    /// Since when the speed readings are zero without a break, if the latest is.
    pub(super) still_since: Stamp,
    pub(super) is_still: bool,
    /// Differs from one echo request to the next, so that a late echo is not taken for the next one.
    pub(super) echo_token: u8,
    pub(super) procedures: Procedures,
    /// When the configuration was read last.
    pub(super) guarded_at: Stamp,
    /// An alarm was reported since the checks began.
    pub(super) has_alarmed: bool,
}

impl Servo {
    pub(super) fn new(axis: &AxisConfig, master: &MasterConfig, rank: u32) -> Self {
        let mut servo = Self {
            config: Settings::of(axis),
            dialect: axis.initial_dialect(),
            ledger: Ledger::NEW,
            drift: DriftWatch::default(),
            feedback: Latest::NONE,
            counters: Counters::default(),
            slot: RequestSlot::default(),
            polls: PollClock::new(&axis.polls, master.cycle_us, rank),
            poll_bits: [0; PollKind::ALL.len()],
            responses: ResponseWatch::NEW,
            timeouts_in_row: 0,
            retry_at: Stamp::ZERO,
            still_since: Stamp::ZERO,
            is_still: false,
            echo_token: 0,
            procedures: Procedures::new(axis.wear, axis.drive_curve),
            guarded_at: Stamp::ZERO,
            has_alarmed: false,
        };
        servo.poll_bits = PollKind::ALL.map(|kind| servo.request_bits(kind));
        servo
    }

    /// Length of the request of a poll on the wire. Not inlined: it is for the start alone.
    #[inline(never)]
    fn request_bits(&self, kind: PollKind) -> u8 {
        let frame = self.frame_of(self.request(kind.reply_kind()));
        frame.map_or(0, |frame| exact_bits(frame.id(), frame.data()) as u8)
    }

    fn is_far_behind(&self) -> bool {
        self.ledger.backlog_counts().unsigned_abs() > self.config.limits.backlog_counts
    }

    #[cold]
    #[inline(never)]
    fn backlog_fault(&self) -> Fault {
        let counts = self.ledger.backlog_counts();
        Fault::Backlog { counts }
    }
}

impl Drive for Servo {
    type Family = Dyn;

    fn group(&self) -> GroupId {
        self.config.group
    }

    fn reaction_to(&self, fault: Fault) -> Reaction {
        self.config.reactions().to(fault)
    }

    #[inline(always)]
    fn snapshot(
        &self,
        now: Instant,
        state: AxisState,
        facts: &Facts,
        fault: Option<Fault>,
    ) -> AxisSnapshot {
        AxisSnapshot {
            drive: self.config.drive,
            group: self.config.group,
            state,
            facts: *facts,
            fault,
            target_counts: self.ledger.target_counts(),
            sent_counts: self.ledger.sent_counts(),
            backlog_counts: self.ledger.backlog_counts(),
            feedback: self.feedback.feedback(now),
            response: self.responses.window(),
            counters: self.counters,
        }
    }

    fn set_target(&mut self, target: i32) -> Result<(), OutOfTravel> {
        let travel = self.config.limits.travel;
        let (min, max) = (travel.min_counts, travel.max_counts);
        if target < min || target > max {
            return Err(OutOfTravel { min, max });
        }
        self.ledger.set_target(target);
        Ok(())
    }

    fn anchor(&mut self, now: Instant) -> Result<(), Fault> {
        let counts = self.located()?;
        self.ledger.anchor(counts);
        self.drift.anchor(now);
        Ok(())
    }

    fn begin_ramp(&mut self, cycles: u32) {
        self.ledger.begin_ramp(cycles);
    }

    fn cycles_to_stop(&self) -> u32 {
        self.ledger.cycles_to_stop(&self.config.limits)
    }

    fn can_stop_in(&self, cycles: u32) -> bool {
        let end = self.ledger.end_of_ramp(cycles);
        let travel = self.config.limits.travel;
        (travel.min_counts..=travel.max_counts).contains(&end)
    }

    fn has_stopped(&self) -> bool {
        self.ledger.has_stopped()
    }

    fn end_motion(&mut self, _: bool) {
        self.ledger.end_motion();
    }

    fn merged(&mut self) {
        self.ledger.missed();
        self.counters.merged = self.counters.merged.wrapping_add(1);
    }

    #[inline(always)]
    fn cycle_frame(&mut self, _: &View) -> Result<DataFrame, Fault> {
        if self.is_far_behind() {
            return Err(self.backlog_fault());
        }
        let step = self.ledger.offer(&self.config.limits);
        let order = self.dialect.number_order;
        Ok(go_relative_pos_pd(self.config.drive, step, order))
    }

    #[inline(always)]
    fn cycle_frame_accepted(&mut self, now: Instant) {
        let step = self.ledger.accepted();
        self.drift.stepped(step, self.ledger.sent_counts(), now);
        self.counters.set_points = self.counters.set_points.wrapping_add(1);
    }

    /// Without the stuff bits of the checksum.
    #[inline(always)]
    fn cycle_frame_bits(&self) -> u8 {
        let backlog = self.ledger.backlog_counts();
        match u8::try_from(backlog.wrapping_add(128)) {
            // One of these beyond the largest step takes as many bits, about.
            Ok(place) => *BYTE_STEP_BITS.get(usize::from(place)).unwrap_or(&0),
            Err(_) => set_point_bits(PdStep::toward(backlog, self.config.limits.max_step).get()),
        }
    }

    fn poll_bits(&self) -> u8 {
        let kind = self.polls.first();
        kind.and_then(|kind| self.poll_bits.get(kind as usize).copied())
            .unwrap_or(0)
    }

    fn switch(&self, on: bool) -> Option<DataFrame> {
        let switch = if on {
            ServoSwitch::Enable
        } else {
            ServoSwitch::Disable
        };
        self.frame_of(Request::ServoDisable(switch))
    }

    fn outlook(&self, view: &View, now: Instant, cycle: u32) -> Outlook {
        let ask = self.next_ask(view, now, cycle);
        let overdue_cycles = ask.map(|(_, overdue_cycles)| overdue_cycles);
        if self.procedures.own().is_some() {
            // What it needs next is a matter of time.
            return Outlook::now(overdue_cycles);
        }
        match ask {
            // Only polls take their time; what else is asked may change at any time.
            Some((Ask::Poll(_), _)) => Outlook {
                overdue_cycles,
                for_us: self.unguarded_us(view, now),
            },
            None if self.slot.is_free() && self.polls.first().is_none() => Outlook {
                overdue_cycles,
                for_us: self.unguarded_us(view, now),
            },
            _ => Outlook::now(overdue_cycles),
        }
    }

    fn wanted(&self, view: &View, now: Instant, cycle: u32) -> Option<Wanted<Request>> {
        let (ask, overdue_cycles) = self.next_ask(view, now, cycle)?;
        let (class, request) = self.request_for(ask, view, now)?;
        Some(Wanted {
            class,
            request,
            overdue_cycles,
        })
    }

    fn request_frame(&self, request: Request) -> Option<DataFrame> {
        if concerns_own_move(&request) {
            return self.own_frame(request);
        }
        self.frame_of(request).filter(|_| self.slot.is_free())
    }

    fn request_accepted(
        &mut self,
        request: Request,
        leaves_at: Instant,
        context: &mut Context<'_, Dyn>,
    ) -> Meaning<Fault> {
        self.note_request(request, leaves_at, context)
    }

    fn returned(&mut self, frame: &DataFrame, context: &mut Context<'_, Dyn>) -> Returned {
        self.note_returned(frame, context)
    }

    fn start_over(&mut self, now: Instant, _: bool) -> Stage {
        self.feedback = Latest::NONE;
        self.procedures.note_curve(None);
        self.timeouts_in_row = 0;
        self.has_alarmed = false;
        match self.procedures.take_start() {
            Some(until) if now < until => Stage::PowerOn,
            _ => Stage::Probing,
        }
    }

    fn response_window(&self) -> Option<ResponseWindow> {
        self.responses.window()
    }

    fn receive(&mut self, frame: &DataFrame, context: &mut Context<'_, Dyn>) -> Meaning<Fault> {
        self.read(frame, context)
    }

    #[inline]
    fn streams_on(&mut self, now: Instant) -> bool {
        self.procedures.is_idle() && !self.is_far_behind() && self.slot.pass(now)
    }

    fn tick(&mut self, context: &mut Context<'_, Dyn>) -> Meaning<Fault> {
        self.ledger.begin_cycle();
        let mut meaning = self.expire(context);
        let view = context.view;
        let power_on_us = context.config.timeouts.power_on_us;
        if view.stage == Stage::PowerOn && view.has_lasted(context.log.now, power_on_us) {
            meaning.stage = Some(Stage::Probing);
        }
        if view.facts.sends_set_points() && self.is_far_behind() {
            meaning.fault = meaning.fault.or_else(|| Some(self.backlog_fault()));
        }
        self.tick_own(context, &mut meaning);
        if self.tick_procedure(&mut context.log) {
            meaning.work_ended = true;
        }
        meaning
    }

    fn keep_stamps(&mut self, now: Instant, is_long_ago: bool) {
        for stamp in [
            &mut self.retry_at,
            &mut self.still_since,
            &mut self.guarded_at,
        ] {
            stamp.keep(now, is_long_ago);
        }
        self.slot.keep_stamps(now, is_long_ago);
        self.drift.keep_stamps(now, is_long_ago);
        self.responses.keep_stamps(now, is_long_ago);
        self.feedback.keep_stamps(now, is_long_ago);
    }

    fn abandon_request(&mut self, context: &mut Context<'_, Dyn>) {
        let quarantine_us = context.config.timeouts.reply_us;
        self.slot.close(context.log.now, quarantine_us);
    }

    fn admit_move(
        &self,
        wanted: DriveMove,
        by_trigger: bool,
        config: &MasterConfig,
        now: Instant,
    ) -> Result<(), MoveRefusal> {
        self.admit_own_move(wanted, by_trigger, config, now)
    }

    fn begin_move(&mut self, wanted: DriveMove, config: &MasterConfig) {
        if let Some(own) = self.own_move(wanted, config) {
            self.procedures.begin_own(own);
        }
    }

    fn has_seen_load(&self) -> bool {
        self.procedures.own().is_some_and(|own| own.is_seen())
    }

    fn loaded_move(&self) -> Option<DriveMove> {
        self.own_wanted()
    }

    fn may_hold_load(&self, kind: DriveMove) -> bool {
        self.was_loaded(kind)
    }

    fn end_move(&mut self, now: Instant, how: Option<MoveEnd>) {
        self.end_own(now, how);
    }

    fn admit(
        &self,
        procedure: Procedure,
        confirmation: Confirmation,
        view: &View,
        now: Instant,
    ) -> Result<Work, ProcedureError> {
        self.admit_procedure(procedure, confirmation, view, now)
    }

    fn begin_work(&mut self, procedure: Procedure) {
        self.procedures.begin(procedure);
    }

    fn abort_work(&mut self, log: &mut Log<'_>) {
        self.abort_procedure(log);
    }
}

/// [`set_point_bits`] of the steps of one byte, from -128 on.
static BYTE_STEP_BITS: [u8; 256] = {
    let mut table = [0; 256];
    let (mut rest, mut step) = (table.as_mut_slice(), -128);
    while let Some((bits, others)) = rest.split_first_mut() {
        *bits = set_point_bits(step);
        (rest, step) = (others, step + 1);
    }
    table
};

/// Length of a set-point behind its identifier, with the stuff bits of its data: what changes from one to the next, without the checksum.
const fn set_point_bits(step: i16) -> u8 {
    // Behind the four bits of the length, on the left.
    let (field, bits): (u32, u8) = if (step as i8) as i16 == step {
        (0x1000_0000 | (step as u8 as u32) << 20, 12)
    } else {
        (0x2000_0000 | (step as u16 as u32) << 12, 20)
    };
    let equal = !(field ^ field << 1) & (!0_u32 << (33 - bits as u32));
    let mut fives = equal & equal << 1 & equal << 2 & equal << 3;
    let mut length = bits;
    while fives != 0 {
        length += 1;
        // The next stuff bit of a run comes five bits later.
        fives &= u32::MAX >> 5 >> fives.leading_zeros();
    }
    length
}
