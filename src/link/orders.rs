//! The half of the cycle: it carries out what the inputs permit of the commands, and plays the segments while every axis follows.

use board_link::board::Command;
use board_link::message::{AxisSnapshot, BoardState};
use board_link::segment::Player;
use board_link::{Reason, Refused};
use board_settings::FaultNumber;
use can_motion::{CommandError, Instant};
use heapless::spsc::{Consumer, Producer};
use trajectory::Position;

use super::homing::Homings;
use super::shared::SHARED;
use crate::config::{AXES, CYCLE_US, Drives, GROUP, Homing};
use crate::drives::{Board as _, BoardFault, BoardMaster};
use crate::machine;
use crate::rules::{Order, Rules, Situation, board_state};
use crate::supervisor::{Axes, Inputs, State, Supervisor};
use crate::words;

/// A command with its ticket.
pub(crate) type Ordered = (u16, Command);
/// What became of a command.
pub(crate) type Result = (u16, core::result::Result<(), Refused>);

/// What the cycle does for the host.
pub(crate) struct Orders {
    player: Player<'static, AXES>,
    commands: Consumer<'static, Ordered>,
    results: Producer<'static, Result>,
    rules: Rules,
    homings: Homings,
    situation: Situation,
    /// Whether a drive may have power, as of so many changes of the facts.
    powered: (u32, bool),
    /// Number of axes.
    axes: usize,
    /// Every axis followed in the cycle before.
    was_streaming: bool,
    /// Where the set-points stand between streams.
    stand: [Position; AXES],
    set_points: [i32; AXES],
    /// The latest cycle, by its time and its number.
    at: Instant,
    cycle: u64,
}

impl Orders {
    /// Nothing was commanded yet.
    pub(super) fn new(
        player: Player<'static, AXES>,
        commands: Consumer<'static, Ordered>,
        results: Producer<'static, Result>,
    ) -> Self {
        Self {
            player,
            commands,
            results,
            rules: Rules::default(),
            homings: Homings::new(),
            situation: Situation {
                inputs: Inputs::default(),
                axes: Axes::default(),
                is_powered: false,
                is_storing: false,
            },
            powered: (0, false),
            axes: machine::axes().len(),
            was_streaming: false,
            stand: [Position::ZERO; AXES],
            set_points: [0; AXES],
            at: Instant::from_us(0),
            cycle: 0,
        }
    }

    /// The run input does nothing here.
    pub(crate) fn start(&mut self, _: &BoardMaster, _: Instant) {}

    /// As above.
    pub(crate) fn finish(&mut self) {}

    /// A cycle in which the supervisor is not asked, because the bus is not there: nothing can be commanded but to store settings, which
    /// may be what keeps the board off the bus. A board that is locked has drives to disable first.
    pub(crate) fn wait(&mut self, is_locked: bool) {
        // Behind the start nothing else says so; later the state is that of the last cycle with a bus.
        if is_locked {
            SHARED.set_state(BoardState::Locked);
        } else if SHARED.state() == BoardState::NoSettings {
            SHARED.set_state(BoardState::Off);
        }
        match self.commands.dequeue() {
            Some((ticket, Command::SaveSettings { .. })) if !is_locked => {
                SHARED.set_storing(true);
                self.answer(ticket, Ok(()));
            }
            Some((ticket, _)) => {
                let refused =
                    Reason::NotReady.because(BoardState::Off as i64, SHARED.state() as i64);
                self.answer(ticket, Err(refused));
            }
            None => {}
        }
        self.player.halt();
    }

    /// Carries out a command, if one has come, and tells what the supervisor shall see of the inputs.
    pub(crate) fn rule(
        &mut self,
        supervisor: &mut Supervisor,
        (inputs, axes): (Inputs, Axes),
        master: &mut BoardMaster,
        now: Instant,
    ) -> Inputs {
        self.situation = Situation {
            inputs: Inputs {
                enable: inputs.enable || !machine::has_enable_input(),
                ..inputs
            },
            axes,
            is_powered: self.is_powered(master),
            is_storing: SHARED.is_storing(),
        };
        if let Some((ticket, result)) = self.rules.outcome(supervisor.state(), self.situation) {
            self.answer(ticket, result);
        }
        if self.homings.is_awaited()
            && let Some(why) = self.rules.ends_homing(supervisor.state(), self.situation)
        {
            self.end_homing(fault_of(master).unwrap_or(why));
        }
        if self.commands.ready()
            && let Some((ticket, command)) = self.commands.dequeue()
            && let Some(result) = self.rules.take(ticket, command, supervisor, self.situation)
        {
            let result = match result {
                // Its result comes when it ends.
                Ok(Order::Home) => self.homings.begin(ticket).err().map(Err),
                Ok(order) => Some(self.carry_out(order, master, now)),
                Err(refused) => Some(Err(refused)),
            };
            if let Some(result) = result {
                self.answer(ticket, result);
            }
        }
        self.rules.contacts(supervisor, self.situation)
    }

    fn carry_out(
        &mut self,
        order: Order,
        master: &mut BoardMaster,
        now: Instant,
    ) -> core::result::Result<(), Refused> {
        match order {
            Order::Nothing | Order::Home => {}
            Order::Stop => self.homings.cancel(),
            Order::Halt => {
                self.end_homing(Reason::HomeStopped.plain());
                self.player.halt();
                master.halt(now, GROUP);
            }
            Order::Disable => {
                self.end_homing(Reason::HomeStopped.plain());
                self.player.halt();
                master.disable(now, GROUP);
            }
            Order::Clear => master.clear(now, GROUP).map_err(refused)?,
            // Nothing is enabled until the thread has done it.
            Order::Store => SHARED.set_storing(true),
        }
        Ok(())
    }

    fn answer(&mut self, ticket: u16, result: core::result::Result<(), Refused>) {
        // There are more places than commands under way, and the thread takes them in every cycle.
        let _ = self.results.enqueue((ticket, result));
    }

    fn end_homing(&mut self, why: Refused) {
        if let Some((ticket, result)) = self.homings.end(why) {
            self.answer(ticket, result);
        }
    }

    fn is_powered(&mut self, master: &BoardMaster) -> bool {
        let changes = master.changes();
        if self.powered.0 != changes {
            let mut facts = (0..AXES).filter_map(|axis| master.facts(axis));
            self.powered = (changes, facts.any(|facts| facts.has_own_power()));
        }
        self.powered.1
    }

    /// Tells the thread where the machine is, after the supervisor.
    pub(crate) fn note(&mut self, state: State, master: &BoardMaster) {
        SHARED.set_state(if self.homings.is_awaited() {
            BoardState::Homing
        } else {
            board_state(state, self.situation)
        });
        if let Some(axis) = SHARED.take_wanted() {
            SHARED.set_late_cycles(master.cycle_counters().late);
            note_axis(axis, master);
        }
    }

    /// Sets the targets of the cycle that begins at `at`, while every axis streams; `now` is the time for the master.
    pub(crate) fn set_targets(
        &mut self,
        master: &mut BoardMaster,
        _: &Homing,
        is_streaming: bool,
        at: Instant,
        now: Instant,
    ) {
        let passed_us = at.us_since(self.at);
        let passed = match u32::try_from(passed_us) {
            Ok(passed_us) => u64::from(passed_us / CYCLE_US),
            Err(_) => many_cycles(passed_us),
        };
        (self.at, self.cycle) = (at, self.cycle + passed);
        if !is_streaming {
            // What was ordered and has not begun yet ends, too.
            self.player.halt();
            self.homings.forget();
            self.was_streaming = false;
            return;
        }
        if !self.was_streaming {
            self.was_streaming = true;
            self.take_stand(master);
        }
        if self.homings.is_active() {
            // Nothing that is ordered meanwhile begins when it has ended.
            self.player.halt();
            if let Some((ticket, result)) = self.homings.cycle(master, now) {
                self.answer(ticket, result);
            }
            self.take_stand(master);
            return;
        }
        let (stand, set_points) = (
            self.stand.get(..self.axes).unwrap_or_default(),
            self.set_points.get_mut(..self.axes).unwrap_or_default(),
        );
        if !self.player.advance_counts(self.cycle, stand, set_points) {
            return;
        }
        for (axis, set_point) in set_points.iter().enumerate() {
            if !self.homings.allows(axis, *set_point) {
                defmt::error!(
                    "axis {=usize}: {=i32} counts are beyond its travel, stopping",
                    axis,
                    *set_point
                );
                master.stop(now, GROUP);
                self.player.halt();
                return;
            }
            if let Err(error) = master.set_target(axis, *set_point) {
                words::target_refused(axis, &error);
                master.stop(now, GROUP);
                self.player.halt();
                return;
            }
        }
        if !self.player.phase().is_active() {
            self.take_stand(master);
        }
    }

    /// Nothing moves the set-points now: that is where the next stream begins.
    fn take_stand(&mut self, master: &BoardMaster) {
        for (axis, stand) in self.stand.iter_mut().enumerate() {
            if let Some(snapshot) = master.snapshot(axis) {
                *stand = Position::from_counts(snapshot.target_counts);
                SHARED.set_target(axis, snapshot.target_counts);
            }
        }
    }
}

fn note_axis(axis: usize, master: &BoardMaster) {
    let (Some(snapshot), Some(config)) = (master.inlined_snapshot(axis), machine::axes().get(axis))
    else {
        return;
    };
    let read = Drives::readings(config, &snapshot);
    let position = read
        .position
        .map_or(snapshot.sent_counts, |read| read.value);
    SHARED.set_axis(
        axis,
        &AxisSnapshot {
            target: snapshot.target_counts,
            position,
            error: snapshot.sent_counts.wrapping_sub(position),
            fault: snapshot
                .fault
                .map_or(0, |fault| FaultNumber::of_axis(fault).code),
        },
    );
}

/// Cycles that have passed behind a bus that was not there for hours. Apart, or the compiler divides with 64 bits in every cycle.
#[cold]
#[inline(never)]
fn many_cycles(us: u64) -> u64 {
    us / u64::from(CYCLE_US)
}

/// The fault of the first axis that has one of its own.
fn fault_of(master: &BoardMaster) -> Option<Refused> {
    (0..AXES).find_map(|axis| {
        let fault = master.snapshot(axis)?.fault?;
        let is_own = fault != BoardFault::Group;
        is_own.then(|| Reason::Faulted.at(axis, 0, FaultNumber::of_axis(fault).code.into()))
    })
}

/// Why the master refuses to forget its faults.
fn refused(error: CommandError<BoardFault>) -> Refused {
    match error {
        CommandError::Faulted { axis, fault } => {
            Reason::Faulted.at(axis.into(), 0, FaultNumber::of_axis(fault).code.into())
        }
        CommandError::Busy { axis } => Reason::Busy.at(axis.into(), 0, 1),
        _ => Reason::NotReady.plain(),
    }
}
