//! A run: one master with its drives and its controller, from a seed.

use std::panic::{AssertUnwindSafe, catch_unwind};

use can_motion::facts::{Knowledge, Motion};
use can_motion::family::Family;
use can_motion::{
    AxisState, BusUser, DriveMove, Event, GroupId, Instant, Master, Outcome, Progress, Sink,
};
use dyn_can::DataFrame;
use fastrand::Rng;

use super::controller::Controller;
use super::history::{Entry, History};
use super::judge::Judge;
use super::subject::{AXES, Answer, Asked, Command, Subject};

/// Cycles of a run, after which another master begins.
pub const RUN_CYCLES: u64 = 5_000;

type Kind<S> = <<S as Subject>::Family as Family>::EventKind;

/// Something that does not hold.
#[derive(Debug, Clone)]
pub struct Finding {
    /// The seed of the run.
    pub seed: u64,
    /// The cycle of the run.
    pub cycle: u64,
    /// What does not hold.
    pub what: String,
    /// What happened last.
    pub history: String,
}

impl std::fmt::Display for Finding {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        let Self {
            seed,
            cycle,
            what,
            history,
        } = self;
        write!(f, "seed {seed}, cycle {cycle}: {what}\n{history}")
    }
}

/// What happened in a run, so that a run in which nothing happens is noticed.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq)]
pub struct Tally {
    /// Cycles.
    pub cycles: u64,
    /// Set-points that the controller took.
    pub set_points: u64,
    /// Set-points and requests that it gave back.
    pub given_back: u64,
    /// Times that an axis began to stream.
    pub streams: u64,
    /// Faults of axes.
    pub faults: u64,
    /// Ledgers that were compared with a drive at rest.
    pub compared: u64,
    /// Motions that drives made by themselves from end to end.
    pub arrivals: u64,
    /// Drives that a trigger started.
    pub triggered: u64,
}

impl Tally {
    /// Adds another run.
    pub fn add(&mut self, other: &Self) {
        self.cycles += other.cycles;
        self.set_points += other.set_points;
        self.given_back += other.given_back;
        self.streams += other.streams;
        self.faults += other.faults;
        self.compared += other.compared;
        self.arrivals += other.arrivals;
        self.triggered += other.triggered;
    }
}

/// Plays the run of a seed; a finding has so many of the latest frames, calls and events.
///
/// # Errors
/// The first thing that does not hold.
#[expect(private_bounds, reason = "the families are those of this module")]
pub fn run<S: Subject>(seed: u64, history: usize) -> Result<Tally, Finding> {
    let mut run = Run::<S>::new(seed, history);
    let played = catch_unwind(AssertUnwindSafe(|| {
        while run.tally.cycles < RUN_CYCLES && run.judge.finding.is_none() {
            run.cycle();
        }
    }));
    let what = match played {
        Err(panic) => {
            let text = panic.downcast_ref::<String>().cloned();
            let text = text.or_else(|| panic.downcast_ref::<&str>().map(ToString::to_string));
            Some(format!("panic: {}", text.unwrap_or_default()))
        }
        Ok(()) => run.judge.finding.take(),
    };
    match what {
        None => Ok(run.tally),
        Some(what) => Err(Finding {
            seed,
            cycle: run.tally.cycles,
            what,
            history: run.history.to_string(),
        }),
    }
}

struct Run<S: Subject> {
    random: Rng,
    subject: S,
    master: Master<AXES, S::Family>,
    judge: Judge,
    controller: Controller,
    answers: Vec<Answer>,
    history: History<Kind<S>>,
    tally: Tally,
    now_us: u64,
    blocked_until_us: u64,
    bus_off_until_us: Option<u64>,
    /// One of so many draws is a disturbance or a call that makes no sense.
    restless: u32,
    speed: [i32; AXES],
}

/// The transmit side of the controller, with the judge beside it.
struct Tap<'a, S: Subject> {
    run_now_us: u64,
    random: &'a mut Rng,
    subject: &'a S,
    controller: &'a mut Controller,
    judge: &'a mut Judge,
    history: &'a mut History<Kind<S>>,
    tally: &'a mut Tally,
    has_failed: bool,
}

impl<S: Subject> Tap<'_, S> {
    fn takes(&mut self, frame: &DataFrame, is_sure: bool) {
        let command = self.subject.command(frame);
        let is_set_point = matches!(command, Command::Step(_) | Command::Target(_));
        self.tally.set_points += u64::from(is_set_point);
        if let Some(axis) = S::axis_of(frame) {
            self.judge
                .takes(axis, (frame.id(), command), self.run_now_us, is_sure);
        } else if command == Command::Trigger {
            let loads = |held: &DataFrame| {
                let command = self.subject.command(held);
                matches!(command, Command::Load(_) | Command::LoadBy(_))
            };
            let holds_loads = self.controller.holds(loads);
            self.judge.triggers(holds_loads);
        }
    }

    fn gives_back(&mut self, frame: &DataFrame) {
        self.tally.given_back += 1;
        self.history.note(self.run_now_us, Entry::GivenBack(*frame));
        if let Some(axis) = S::axis_of(frame) {
            self.judge.gives_back(axis, self.subject.command(frame));
        } else if self.subject.command(frame) == Command::Trigger {
            self.judge.trigger_comes_back();
        }
    }
}

impl<S: Subject> Sink<DataFrame> for Tap<'_, S> {
    fn offer(&mut self, frame: &DataFrame) -> Outcome<DataFrame> {
        let outcome = self.controller.offer(self.run_now_us, frame, self.random);
        let (name, is_taken) = match outcome {
            Outcome::Accepted => ("taken", true),
            Outcome::Displaced(_) => ("taken for another", true),
            Outcome::Full => ("full", false),
            Outcome::Failed(_) => ("failed", true),
        };
        self.history
            .note(self.run_now_us, Entry::Offered(*frame, name));
        let is_sure = !matches!(outcome, Outcome::Failed(_));
        self.has_failed |= !is_sure;
        if is_taken {
            self.takes(frame, is_sure);
        }
        if let Outcome::Displaced(other) = outcome {
            self.gives_back(&other);
        }
        outcome
    }

    fn take_back(&mut self) -> Option<DataFrame> {
        let frame = self.controller.take_back()?;
        self.gives_back(&frame);
        Some(frame)
    }
}

impl<S: Subject> Run<S> {
    fn new(seed: u64, history: usize) -> Self {
        let mut random = Rng::with_seed(seed);
        let subject = S::draw(&mut random);
        Self {
            master: subject.master(),
            judge: Judge::new(subject.rules()),
            controller: Controller::draw(&mut random),
            answers: Vec::new(),
            history: History::new(history),
            tally: Tally::default(),
            now_us: random.u64(..1_000_000),
            blocked_until_us: 0,
            bus_off_until_us: None,
            restless: random.u32(20..2_000),
            speed: [0; AXES],
            subject,
            random,
        }
    }

    fn now(&self) -> Instant {
        Instant::from_us(self.now_us)
    }

    fn rarely(&mut self, once_in: u32) -> bool {
        self.random.u32(..once_in) == 0
    }

    fn cycle(&mut self) {
        self.tally.cycles += 1;
        let started_us = self.now_us;
        self.trouble();
        self.history
            .note(self.now_us, Entry::Cycle(self.tally.cycles));
        self.judge.begins(self.now_us);
        let now = self.now();
        self.master.begin_cycle(now);
        self.read_events();
        self.judge.has_begun();
        let rounds = self.random.u32(1..=3);
        for _ in 0..rounds {
            self.call();
            self.send();
            self.wire();
        }
        self.compare();
        self.advance(started_us);
    }

    /// To the next cycle, or beyond it.
    fn advance(&mut self, started_us: u64) {
        let cycle_us = self.judge.rules.cycle_us;
        let jump_us = match self.random.u32(..4_000) {
            0 => cycle_us * self.random.u64(20..2_000),
            1..=10 => cycle_us * self.random.u64(1..30),
            _ => 0,
        };
        let jitter_us = self.random.u64(0..cycle_us / 10);
        self.now_us = self
            .now_us
            .max(started_us + cycle_us - cycle_us / 20 + jitter_us)
            + jump_us;
    }

    /// What happens to bus and drives.
    fn trouble(&mut self) {
        let cycle_us = self.judge.rules.cycle_us;
        if self.rarely(1_500) {
            self.blocked_until_us = self.now_us + cycle_us * self.random.u64(1..60);
        }
        self.controller.is_blocked = self.now_us < self.blocked_until_us;
        let goes_off = self.rarely(6_000);
        match self.bus_off_until_us {
            Some(until_us) if self.now_us >= until_us => {
                self.bus_off_until_us = None;
                self.judge.is_bus_off = false;
                let now = self.now();
                self.master.on_bus_recovered(now);
                self.read_events();
            }
            None if goes_off => {
                self.bus_off_until_us = Some(self.now_us + cycle_us * self.random.u64(1..50));
                self.history.note(self.now_us, Entry::Call("bus-off", 0));
                self.controller.forget();
                self.judge.bus_off();
                let now = self.now();
                self.master.on_bus_off(now);
                self.read_events();
            }
            _ => {}
        }
        if self.rarely(self.restless) {
            let axis = self.random.usize(..AXES);
            let what = self
                .subject
                .disturb(axis, self.now_us, &mut self.random, &mut self.answers);
            self.history.note(self.now_us, Entry::Happened(what, axis));
        }
        self.subject
            .pass(self.now_us, &mut self.random, &mut self.answers);
    }

    fn read_events(&mut self) {
        while let Some(Event { axis, kind, .. }) = self.master.next_event() {
            self.history.note(self.now_us, Entry::Event(axis, kind));
            let Some(axis) = axis else { continue };
            let axis = usize::from(axis);
            let seen = self.subject.seen(axis, &kind);
            use super::subject::Seen;
            self.tally.faults += u64::from(matches!(seen, Seen::Fault { .. }));
            let streams = matches!(
                seen,
                Seen::State {
                    to: AxisState::Streaming,
                    ..
                }
            );
            self.tally.streams += u64::from(streams);
            let arrives = matches!(
                seen,
                Seen::State {
                    from: AxisState::DriveMoving,
                    to: AxisState::Holding,
                    ..
                }
            );
            self.tally.arrivals += u64::from(arrives);
            self.judge.sees(axis, seen, self.now_us);
        }
    }

    fn send(&mut self) {
        let now = self.now();
        let mut tap = Tap::<S> {
            run_now_us: self.now_us,
            random: &mut self.random,
            subject: &self.subject,
            controller: &mut self.controller,
            judge: &mut self.judge,
            history: &mut self.history,
            tally: &mut self.tally,
            has_failed: false,
        };
        let progress = self.master.send(now, &mut tap);
        let is_through = progress == Progress::Idle && !tap.has_failed;
        self.read_events();
        if is_through && !self.judge.is_bus_off {
            self.judge.is_idle();
        }
    }

    /// Frames leave, and those of the drives come in.
    fn wire(&mut self) {
        for _ in 0..self.random.u32(0..6) {
            if self.bus_off_until_us.is_some() {
                break;
            }
            let Some(sent) = self.controller.transmit() else {
                break;
            };
            self.history.note(self.now_us, Entry::OnWire(sent.frame));
            self.now_us += 60;
            let axis = S::axis_of(&sent.frame);
            let switches = |frame: &DataFrame| {
                let command = self.subject.command(frame);
                S::axis_of(frame) == axis && command == Command::On
            };
            let asked = Asked {
                taken_us: sent.taken_us,
                is_behind_switches: !self.controller.holds(switches),
            };
            let (random, answers) = (&mut self.random, &mut self.answers);
            self.subject
                .take(self.now_us, &sent.frame, asked, random, answers);
            for (axis, is_started) in self.subject.triggered().into_iter().enumerate() {
                if is_started {
                    self.tally.triggered += 1;
                    self.judge.started(axis);
                }
            }
        }
        self.now_us += self.random.u64(0..100);
        while let Some(place) = self
            .answers
            .iter()
            .position(|answer| answer.due_us <= self.now_us)
        {
            let answer = self.answers.remove(place);
            if self.bus_off_until_us.is_none() {
                self.deliver(answer);
            }
        }
    }

    fn deliver(&mut self, answer: Answer) {
        self.history
            .note(self.now_us, Entry::Delivered(answer.frame));
        let told = self.subject.told(&answer.frame);
        let axis = S::axis_of(&answer.frame);
        let id = S::question_of(&answer.frame);
        let is_alarm = axis.is_some_and(|axis| {
            self.judge
                .delivers(axis, id, told, answer.asked, self.now_us)
        });
        let now = self.now();
        self.master.on_frame(now, &answer.frame);
        self.read_events();
        if let Some(axis) = axis.filter(|_| is_alarm) {
            self.judge.has_alarmed(axis);
        }
        self.compare();
    }

    /// Ledgers against what the master believes, and against drives at rest.
    fn compare(&mut self) {
        for axis in 0..AXES {
            let facts = self.master.facts(axis).expect("an axis");
            if facts.motion == Motion::DriveMove {
                continue;
            }
            let snapshot = self.master.snapshot(axis).expect("an axis");
            let sent = (facts.knowledge == Knowledge::Anchored && S::compares(&facts))
                .then(|| S::sent(&snapshot));
            if self.judge.compares(axis, sent) {
                self.subject.anchored(axis);
            }
            let moves = |frame: &DataFrame| {
                let command = self.subject.command(frame);
                S::axis_of(frame) == Some(axis)
                    && matches!(command, Command::Step(_) | Command::Target(_))
            };
            let position = self.subject.undisturbed_position(axis);
            if let Some((sent, position)) = sent.zip(position)
                && !self.controller.holds(moves)
            {
                self.tally.compared += 1;
                if i64::from(sent) != position {
                    let what = format!("sent {sent}, the drive is at {position}");
                    self.judge.broken(axis, what);
                }
            }
        }
    }

    /// A call of the application: mostly what leads on, sometimes anything.
    fn call(&mut self) {
        self.set_targets();
        let axis = self.random.usize(..AXES);
        let group = self.judge.rules.groups[axis];
        let state = self.master.state(axis).expect("an axis");
        let choice = match state {
            _ if self.rarely(self.restless) => self.random.u8(..11),
            _ if !self.rarely(30) => return,
            AxisState::Ready => 0,
            AxisState::Holding if S::HAS_MOVES => [1, 1, 9, 10][self.random.usize(..4)],
            AxisState::Holding => 1,
            AxisState::Streaming if S::HAS_MOVES && self.rarely(20) => 5,
            AxisState::Loaded => 4,
            AxisState::DriveMoving if self.rarely(8) => 5,
            AxisState::FoundOn => 2 + 2 * self.random.u8(..2),
            AxisState::Faulted => 3,
            AxisState::Disabling => 3,
            _ => return,
        };
        self.make(choice, axis, group);
        self.read_events();
    }

    fn make(&mut self, choice: u8, axis: usize, group: u8) {
        let (now, now_us, id) = (self.now(), self.now_us, GroupId(group));
        let names = [
            "enable",
            "resume",
            "adopt",
            "clear",
            "disable",
            "stop",
            "halt",
            "procedure",
            "target",
            "move",
            "moves",
        ];
        self.history
            .note(now_us, Entry::Call(names[usize::from(choice)], axis));
        match choice {
            0 => {
                if self.master.enable(now, id).is_ok() {
                    self.judge.enabled(group, now_us);
                }
            }
            1 => {
                if self.master.resume(now, id).is_ok() {
                    self.judge.resumed(group, now_us);
                }
            }
            2 => {
                let states = [0, 1, 2].map(|axis| self.master.state(axis));
                if self.master.adopt(now, id).is_ok() {
                    let found = states.map(|state| state == Some(AxisState::FoundOn));
                    self.judge.adopted(group, found);
                }
            }
            3 => {
                if self.master.clear(now, id).is_ok() {
                    self.judge.cleared(group);
                }
            }
            4 => {
                self.judge.disabled(group);
                self.master.disable(now, id);
            }
            5 => {
                self.judge.stop(group, true);
                self.master.stop(now, id);
            }
            6 => {
                self.judge.stop(group, false);
                self.master.halt(now, id);
            }
            7 => {
                if let Some((procedure, confirmation)) = S::procedure(&mut self.random) {
                    let _ = self.master.start(now, axis, procedure, confirmation);
                }
            }
            9 => {
                let wanted = self.any_move(axis);
                self.let_move(&[(axis, wanted)], false);
            }
            10 => {
                let axes: Vec<usize> = self.judge.in_group(group).collect();
                let is_relative = self.random.bool();
                let moves = axes
                    .into_iter()
                    .map(|axis| (axis, self.move_of(axis, is_relative)));
                let moves: Vec<_> = moves.collect();
                self.let_move(&moves, true);
            }
            _ => {
                let target = self.random.i32(..);
                let _ = self.master.set_target(axis, target);
            }
        }
    }

    fn any_move(&mut self, axis: usize) -> DriveMove {
        let is_relative = self.random.bool();
        self.move_of(axis, is_relative)
    }

    /// A move within the travel, mostly.
    fn move_of(&mut self, axis: usize, is_relative: bool) -> DriveMove {
        let limits = self.judge.rules.axes[axis];
        let sent = S::sent(&self.master.snapshot(axis).expect("an axis"));
        let near = sent + self.random.i32(-300..=300);
        let end = match self.random.u8(..20) {
            0 => limits.max + 1,
            1 => self.random.i32(limits.min..=limits.max),
            _ => near.clamp(limits.min, limits.max),
        };
        match is_relative {
            true => DriveMove::By(end - sent),
            false => DriveMove::To(end),
        }
    }

    fn let_move(&mut self, moves: &[(usize, DriveMove)], by_trigger: bool) {
        let now = self.now();
        let is_taken = match moves {
            [(axis, wanted)] if !by_trigger => self.master.start_move(now, *axis, *wanted).is_ok(),
            _ => self.master.start_moves(now, moves).is_ok(),
        };
        for &(axis, wanted) in moves.iter().filter(|_| is_taken) {
            let start = S::sent(&self.master.snapshot(axis).expect("an axis"));
            let (end, is_relative) = match wanted {
                DriveMove::By(distance) => (start + distance, true),
                DriveMove::To(end) => (end, false),
                _ => continue,
            };
            self.judge
                .asked_to_move(axis, (start, end), (is_relative, by_trigger));
        }
    }

    /// Targets wander within the travel, sometimes at once to its other end.
    fn set_targets(&mut self) {
        for axis in 0..AXES {
            if self.master.state(axis) != Some(AxisState::Streaming) {
                continue;
            }
            let limits = self.judge.rules.axes[axis];
            if self.rarely(40) {
                self.speed[axis] = self.random.i32(-limits.max_step..=limits.max_step);
            }
            let snapshot = self.master.snapshot(axis).expect("an axis");
            let near = S::sent(&snapshot) + self.speed[axis];
            let target = match self.random.u32(..2_000) {
                0 => self.random.i32(limits.min..=limits.max),
                1 => limits.max.saturating_add(1),
                _ => near.clamp(limits.min, limits.max),
            };
            let is_taken = self.master.set_target(axis, target).is_ok();
            if is_taken && !(limits.min..=limits.max).contains(&target) {
                self.judge
                    .broken(axis, format!("the target {target} was taken"));
            }
        }
    }
}
