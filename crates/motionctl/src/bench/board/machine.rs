//! The cycle of the board: master and player, as the rules let them.

use board_link::board::{Command, Machine as Told};
use board_link::message::{AxisSnapshot as ToldAxis, BoardState, Event, Reason, Refused};
use board_link::segment::Player;
use board_settings::{Configs, FaultNumber, HomingSequence, HomingStep};
use can_motion::{AxisState, ConfigError, EventKind, Fault, GroupId, Instant, ServoMaster};
use drive_sim::{Bench, DynDrive, NodeId};
use dyn_can::DriveId;
use homing::{Inputs, Reading};
use trajectory::Position;

use super::AXES;
use super::application::App;
use super::inputs::Levels;
use super::rules::{Act, Axes, Rules};

/// A board that has settings.
pub(super) struct Machine<'q> {
    master: ServoMaster<AXES>,
    player: Player<'q, AXES>,
    configs: Configs,
    groups: Vec<GroupId>,
    rules: Rules,
    sequence: HomingSequence<AXES>,
    /// The command that waits for the end of a homing.
    homing: Option<u16>,
    state: BoardState,
}

impl<'q> Machine<'q> {
    /// A machine of settings that were checked.
    pub(super) fn new(configs: Configs, player: Player<'q, AXES>) -> Result<Self, ConfigError> {
        let master = ServoMaster::with_plan(&configs.plan())?;
        let mut groups: Vec<GroupId> = configs.axes.iter().map(|axis| axis.group).collect();
        groups.sort_unstable_by_key(|group| group.0);
        groups.dedup();
        Ok(Self {
            master,
            player,
            rules: Rules::new(configs.enable_fitted),
            configs,
            groups,
            sequence: HomingSequence::NEW,
            homing: None,
            state: BoardState::Off,
        })
    }

    /// The bit rate that the settings say.
    pub(super) const fn kbit_per_s(&self) -> u32 {
        self.configs.master.bus.bit_rate.kbit_per_s()
    }

    /// Hands frames both ways.
    pub(super) fn serve(&mut self, now: Instant, bench: &mut Bench<DynDrive>, node: NodeId) {
        // Whether it is idle or blocked, the next event on the bus is the next chance.
        let _ = can_motion::service(&mut self.master, &mut bench.port(node), now);
    }

    /// One cycle; `switch` is the level of the switch of a drive.
    pub(super) fn cycle(
        &mut self,
        (now, number): (Instant, u64),
        inputs: Levels,
        app: &mut App,
        switch: impl Fn(DriveId) -> bool,
    ) {
        let axes = self.axes();
        if self.homing.is_some()
            && let Some(why) = self.ends_homing(inputs, &axes)
        {
            self.end_homing(why, app);
        }
        // One in a cycle, as the boards do: each sees what the one before has made of the axes.
        if let Some((ticket, command)) = app.commands.pop_front() {
            self.obey(now, inputs, &axes, (ticket, command), app);
        }
        let act = self.rules.update(now, inputs, &axes);
        self.act(now, act);
        self.home(now, app, switch);
        self.play(now, number);
        self.master.begin_cycle(now);
        self.report(number, inputs, app);
    }

    fn obey(
        &mut self,
        now: Instant,
        inputs: Levels,
        axes: &Axes,
        (ticket, command): (u16, Command),
        app: &mut App,
    ) {
        let result = match command {
            Command::Enable => self.rules.enable(now, inputs, axes),
            Command::Disable => {
                self.end_homing(Reason::HomeStopped.plain(), app);
                let act = self.rules.disable();
                self.act(now, act);
                Ok(())
            }
            // A stream stops by its player.
            Command::Stop => {
                self.sequence.cancel();
                Ok(())
            }
            Command::Halt => {
                self.end_homing(Reason::HomeStopped.plain(), app);
                let act = self.rules.halt();
                self.act(now, act);
                Ok(())
            }
            Command::Clear if axes.fault.is_none() => Ok(()),
            Command::Clear => self.for_groups(|master, group| {
                let (off, faulted) = (BoardState::Off as i64, BoardState::Faulted as i64);
                let cleared = master.clear(now, group);
                cleared.map_err(|_| Reason::NotReady.because(off, faulted))
            }),
            Command::Home => {
                let begun = match self.ends_homing(inputs, axes) {
                    Some(refused) => Err(refused),
                    None => self.sequence.begin(&self.configs.homings),
                };
                match begun {
                    // Its result comes when it ends.
                    Ok(()) => return self.homing = Some(ticket),
                    Err(refused) => Err(refused),
                }
            }
            Command::SaveSettings { .. } => Err(Reason::Unsupported.plain()),
        };
        app.results.push_back((ticket, result));
    }

    /// Why the axes cannot be homed, or not any more.
    fn ends_homing(&self, inputs: Levels, axes: &Axes) -> Option<Refused> {
        if self.rules.is_stopped(inputs) {
            return Some(Reason::StopInput.plain());
        }
        if self.rules.is_released(inputs) {
            return Some(Reason::EnableInput.plain());
        }
        if let Some((axis, number)) = axes.fault {
            return Some(Reason::Faulted.at(axis, 0, number.into()));
        }
        let (enabled, is) = (BoardState::Enabled as i64, self.state as i64);
        let follows = axes.streaming && self.rules.wants_power();
        (!follows).then(|| Reason::NotEnabled.because(enabled, is))
    }

    /// The command does not wait any more; where set-points go on all the same, the axis slows down.
    fn end_homing(&mut self, why: Refused, app: &mut App) {
        if let Some(ticket) = self.homing.take() {
            self.sequence.cancel();
            let axis = why.axis.or(Some(self.sequence.axis() as u8));
            let refused = Refused { axis, ..why };
            app.results.push_back((ticket, Err(refused)));
        }
    }

    /// The set-point of the axis that searches its origin. What is known is forgotten when the axes do not follow.
    fn home(&mut self, now: Instant, app: &mut App, switch: impl Fn(DriveId) -> bool) {
        if !self.axes().streaming || !self.rules.wants_power() {
            self.sequence = HomingSequence::NEW;
        }
        let (master, configs) = (&self.master, &self.configs);
        let step = self.sequence.cycle(&configs.homings, now.as_us(), |axis| {
            let (snapshot, config) = (master.snapshot(axis)?, configs.axes.get(axis)?);
            let read = &snapshot.feedback;
            Some(Inputs {
                sent_counts: snapshot.sent_counts,
                position: read.position.and_then(|read| {
                    Some(Reading {
                        value: config.read_back.to_command_counts(read.value)?,
                        at_us: read.at.as_us(),
                    })
                }),
                torque_permille: read.torque.map(|read| Reading {
                    value: read.value.permille_of_peak(),
                    at_us: read.at.as_us(),
                }),
                switch: Some(Reading {
                    value: switch(config.drive),
                    at_us: now.as_us(),
                }),
            })
        });
        let result = match step {
            None => return,
            Some(HomingStep::Target(axis, counts)) => {
                if self.master.set_target(axis, counts).is_ok() {
                    return;
                }
                self.sequence = HomingSequence::NEW;
                self.stop(now);
                Err(Reason::HomePlan.at(axis, 0, 0))
            }
            Some(HomingStep::Found(axis, home)) => {
                app.events.push_back(Event::Homed {
                    axis: axis as u8,
                    counts: home.frame.origin_counts(),
                    uncertainty: home.uncertainty_counts,
                });
                return;
            }
            Some(HomingStep::Ended(result)) => result.map_err(|(refused, _)| {
                if refused.is(Reason::HomePlan) {
                    self.stop(now);
                }
                refused
            }),
        };
        if let Some(ticket) = self.homing.take() {
            app.results.push_back((ticket, result));
        }
    }

    fn for_groups(
        &mut self,
        mut deed: impl FnMut(&mut ServoMaster<AXES>, GroupId) -> Result<(), Refused>,
    ) -> Result<(), Refused> {
        for &group in &self.groups {
            deed(&mut self.master, group)?;
        }
        Ok(())
    }

    /// Slows every axis down.
    fn stop(&mut self, now: Instant) {
        for &group in &self.groups {
            self.master.stop(now, group);
        }
    }

    fn act(&mut self, now: Instant, act: Act) {
        if act != Act::Nothing {
            self.player.halt();
        }
        let refused = |_| Reason::NotReady.plain();
        let done = self.for_groups(|master, group| match act {
            Act::Nothing => Ok(()),
            Act::Halt => {
                master.halt(now, group);
                Ok(())
            }
            Act::Disable => {
                master.disable(now, group);
                Ok(())
            }
            // A group without such a drive has nothing to take over.
            Act::Adopt => {
                let _ = master.adopt(now, group);
                Ok(())
            }
            Act::Enable => master.enable(now, group).map_err(refused),
        });
        if done.is_err() {
            self.rules.refused();
        }
    }

    /// The set-points of this cycle. While not every axis follows them, a stream that was begun ends.
    fn play(&mut self, now: Instant, number: u64) {
        let axes = self.configs.axes.len();
        let mut stand = [Position::ZERO; AXES];
        for (axis, stand) in stand.iter_mut().enumerate().take(axes) {
            let target = self
                .master
                .snapshot(axis)
                .map_or(0, |axis| axis.target_counts);
            *stand = Position::from_counts(target);
        }
        let mut set_points = stand;
        let has_set_points = self
            .player
            .advance(number, &stand[..axes], &mut set_points[..axes]);
        if !self.axes().streaming || !self.rules.wants_power() || self.sequence.is_active() {
            return self.player.halt();
        }
        if !has_set_points {
            return;
        }
        for (axis, set_point) in set_points.iter().enumerate().take(axes) {
            let (homings, counts) = (&self.configs.homings, set_point.counts());
            let is_allowed = self.sequence.allows(homings, axis, counts);
            if !is_allowed || self.master.set_target(axis, counts).is_err() {
                // Beyond what was admitted: nothing of it is sent.
                self.player.halt();
                return self.stop(now);
            }
        }
    }

    /// The axes before this cycle.
    fn axes(&self) -> Axes {
        let mut all = Axes {
            ready: true,
            streaming: true,
            ..Axes::default()
        };
        let mut can_follow = true;
        for place in 0..self.configs.axes.len() {
            let Some(axis) = self.master.snapshot(place) else {
                continue;
            };
            let is = |state| axis.state == state;
            all.ready &= is(AxisState::Ready) || is(AxisState::Holding);
            all.streaming &= is(AxisState::Streaming);
            can_follow &= is(AxisState::Ready) || is(AxisState::Holding) || is(AxisState::FoundOn);
            all.adoptable |= is(AxisState::FoundOn);
            all.powered |= axis.facts.has_own_power();
            // One that only stopped with its group is not the cause.
            if let Some(fault) = axis.fault
                && (all.fault.is_none() || fault != Fault::Group)
            {
                all.fault = all.fault.filter(|_| fault == Fault::Group);
                all.fault
                    .get_or_insert((place, FaultNumber::of_axis(fault).code));
            }
        }
        all.adoptable &= can_follow;
        all
    }

    /// Whether a drive has power, or is about to have.
    pub(super) fn is_powered(&self) -> bool {
        let is_found_on = |axis| self.master.state(axis) == Some(AxisState::FoundOn);
        self.rules.wants_power()
            || self.axes().powered
            || (0..self.configs.axes.len()).any(is_found_on)
    }

    fn report(&mut self, number: u64, inputs: Levels, app: &mut App) {
        while let Some(event) = self.master.next_event() {
            let Some(fault) = FaultNumber::of_event(&event.kind) else {
                continue;
            };
            let axis = event.axis;
            let FaultNumber { code, detail } = fault;
            app.events.push_back(Event::Fault { axis, code, detail });
            if event.kind != EventKind::Fault(Fault::Group) {
                let uptime_us = number * u64::from(self.configs.master.cycle_us);
                let uptime_ms = (uptime_us / 1_000) as u32;
                app.faults.add(uptime_ms, axis, fault);
            }
        }
        let state = self.state_with(inputs);
        if state != self.state {
            self.state = state;
            app.events.push_back(Event::State(state));
        }
        app.machine = Told {
            state,
            axes: (0..self.configs.axes.len())
                .filter_map(|axis| self.told(axis))
                .collect(),
            late_cycles: self.master.cycle_counters().late,
        };
        app.origins = (0..self.configs.axes.len())
            .map(|axis| self.sequence.origin(&self.configs.homings, axis))
            .collect();
    }

    fn state_with(&self, inputs: Levels) -> BoardState {
        let axes = self.axes();
        let slows_down = (0..self.configs.axes.len()).any(|axis| {
            let state = self.master.state(axis);
            matches!(state, Some(AxisState::RampingDown | AxisState::Disabling))
        });
        if self.rules.is_stopped(inputs) {
            BoardState::StopOpen
        } else if axes.fault.is_some() {
            BoardState::Faulted
        } else if slows_down {
            BoardState::Stopping
        } else if self.rules.is_released(inputs) {
            BoardState::EnableInactive
        } else if self.homing.is_some() {
            BoardState::Homing
        } else if axes.streaming && self.rules.wants_power() {
            BoardState::Enabled
        } else if self.rules.wants_power() {
            BoardState::GettingReady
        } else if axes.powered {
            BoardState::Halted
        } else {
            BoardState::Off
        }
    }

    fn told(&self, place: usize) -> Option<ToldAxis> {
        let (axis, config) = (self.master.snapshot(place)?, self.configs.axes.get(place)?);
        let read = axis.feedback.position;
        let position = read.and_then(|read| config.read_back.to_command_counts(read.value));
        let position = position.unwrap_or(axis.sent_counts);
        Some(ToldAxis {
            target: axis.target_counts,
            position,
            error: axis.target_counts.wrapping_sub(position),
            fault: axis
                .fault
                .map_or(0, |fault| FaultNumber::of_axis(fault).code),
        })
    }
}
