//! The master: any configuration, then any calls in any order, on a driver that does anything.

use can_motion::facts::Class;
use can_motion::plan::{BitRate, BusPlan, BusSetup, Canopen, RequestMix, ResponseWindow, TxOrder};
use can_motion::{
    AxisConfig, AxisState, BusErrorKind, BusUser, Confirmation, DialectChoice, DriveMove, GroupId,
    Instant, Limits, MasterConfig, MotorLimits, Outcome, PollPeriods, Procedure, Reaction,
    Reactions, ReadBackScale, ServoMaster, Sink, StepChange, Timeouts, Travel, WaveShape,
    WearLimits, service, service_taking_back,
};
use dyn_can::{GearNumber, Request, StepLimit};
use trajectory::curve::{Keyframe, KeyframeMotion};

use crate::codec::{dialect, drive, frame, request};
use crate::fake_can::{FakeCan, FakeFrame};
use crate::opaque::{self, consume, word};

/// Axes of the master that is exercised.
pub(crate) const AXES: usize = 8;

/// A motion, and a master with any number of calls.
pub fn exercise() {
    motion();
    run(look);
}

/// Any calls on any master in any order; `look` is one of them.
pub(crate) fn run(look: fn(&mut ServoMaster<AXES>)) {
    let axes = [(); AXES].map(|()| axis());
    let given = axes.get(..word() as usize).unwrap_or(&axes);
    let mut master = match ServoMaster::<AXES>::new(config(), given) {
        Ok(master) => master,
        Err(error) => return consume(error),
    };
    while opaque::flag() {
        match opaque::byte() {
            // From one plan to another.
            0 => consume(master.take_on(&BusPlan::new(&config(), given))),
            1..16 => cycle(&mut master),
            16..32 => bus(&mut master),
            32..48 => by_hand(&mut master),
            48..64 => commands(&mut master),
            _ => look(&mut master),
        }
    }
}

/// Any moment.
pub(crate) fn now() -> Instant {
    Instant::from_us(opaque::bits())
}

/// Any group.
pub(crate) fn group() -> GroupId {
    GroupId(opaque::byte())
}

/// Any settings, also such that cannot work.
pub(crate) fn config() -> MasterConfig {
    MasterConfig {
        cycle_us: word(),
        requests_per_cycle: opaque::byte(),
        timeouts: Timeouts {
            power_on_us: word(),
            reply_us: word(),
            settle_us: word(),
            alarm_quiet_us: word(),
            arrival_us: word(),
            standstill_us: word(),
            standstill_limit_us: word(),
            confirm_us: word(),
            stuck_us: word(),
            lost_after: opaque::byte(),
        },
        bus: bus_setup(),
    }
}

/// Any bus.
fn bus_setup() -> BusSetup {
    BusSetup {
        bit_rate: opaque::pick([BitRate::Kbit10, BitRate::Kbit800, BitRate::Kbit1000]),
        order: opaque::pick([TxOrder::Fifo, TxOrder::Identifier]),
        response: ResponseWindow {
            min_us: word(),
            max_us: word(),
        },
        requests: opaque::pick([RequestMix::Polls, RequestMix::Any]),
        release_jitter_us: word(),
        alarm_burst: opaque::byte(),
        error_interval_us: opaque::maybe(word()),
        canopen: opaque::maybe(Canopen {
            nodes: opaque::pick::<&[u8], 3>([&[], &[1, 127], &[0]]),
            uses_nmt: opaque::flag(),
            uses_sync: opaque::flag(),
        }),
    }
}

/// Any axis, also one that cannot work.
pub(crate) fn axis() -> AxisConfig {
    let period = || opaque::maybe(word());
    let reaction = || opaque::pick([Reaction::Halt, Reaction::RampDown, Reaction::Disable]);
    AxisConfig {
        dialect: opaque::pick([DialectChoice::Detect, DialectChoice::Fixed(dialect())]),
        group: group(),
        polls: PollPeriods {
            status_us: period(),
            position_us: period(),
            torque_us: period(),
            speed_us: period(),
            counter_us: period(),
        },
        unwatched: opaque::flag(),
        drive_curve: drive_curve(),
        load_can_fall: opaque::flag(),
        read_back: read_back(),
        reactions: Reactions {
            alarm: reaction(),
            data_error: reaction(),
            lost: reaction(),
            backlog: reaction(),
            position: reaction(),
            bus: reaction(),
        },
        wear: WearLimits {
            budget: word() as u16,
            interval_us: word(),
        },
        ..AxisConfig::new(drive(), gear(), limits())
    }
}

/// Any gear number.
pub(crate) fn gear() -> GearNumber {
    GearNumber::new(opaque::number()).unwrap_or(GearNumber::MAX)
}

/// Any limits, also such that contradict each other.
fn limits() -> Limits {
    let travel = opaque::pick([
        Travel {
            min_counts: opaque::number(),
            max_counts: opaque::number(),
        },
        Travel::of_motor_millidegrees(opaque::bits() as i64, opaque::bits() as i64, gear()),
    ]);
    let max_step = StepLimit::new(opaque::number()).unwrap_or(StepLimit::MAX);
    let change = opaque::pick([
        StepChange::from_counts(word()),
        StepChange::from_256ths(word()),
    ]);
    let motor = MotorLimits {
        speed_rpm: word(),
        acceleration_rpm_per_s: word(),
    };
    let given = Limits::new(max_step, change.unwrap_or(StepChange::MAX), travel);
    Limits {
        backlog_counts: word(),
        following_error_counts: word(),
        drift_tolerance_counts: word(),
        ..Limits::of_motor(motor, travel, gear(), word()).unwrap_or(given)
    }
}

fn read_back() -> ReadBackScale {
    opaque::pick([
        ReadBackScale {
            read_back_counts: word(),
            command_counts: word(),
        },
        ReadBackScale::movement_positions(gear()),
        ReadBackScale::motor_steps(gear()),
    ])
}

fn cycle(master: &mut ServoMaster<AXES>) {
    consume(master.set_target(word() as usize, opaque::number()));
    master.begin_cycle(now());
    consume(service(master, &mut FakeCan, now()));
}

fn bus(master: &mut ServoMaster<AXES>) {
    match opaque::byte() {
        0 => master.on_bus_off(now()),
        1 => master.on_bus_recovered(now()),
        2 => consume(service_taking_back(master, &mut FakeCan, now(), |_| {
            opaque::maybe(FakeFrame::any())
        })),
        _ => consume(service(master, &mut FakeCan, now())),
    }
}

/// A sink that does with a frame whatever it likes, and gives back frames that it never got.
pub(crate) struct AnySink<A> {
    /// Makes any frame.
    pub(crate) any: A,
}

impl<Fr: Copy, A: FnMut() -> Option<Fr>> Sink<Fr> for AnySink<A> {
    fn offer(&mut self, frame: &Fr) -> Outcome<Fr> {
        consume(*frame);
        match (opaque::byte(), (self.any)()) {
            (0, _) => Outcome::Full,
            (1, _) => Outcome::Failed(opaque::pick([BusErrorKind::Overrun, BusErrorKind::Other])),
            (2, Some(displaced)) => Outcome::Displaced(displaced),
            _ => Outcome::Accepted,
        }
    }

    fn has_room(&self) -> bool {
        opaque::flag()
    }

    fn take_back(&mut self) -> Option<Fr> {
        (self.any)()
    }
}

/// What `service` does, in an order that no driver would cause.
fn by_hand(master: &mut ServoMaster<AXES>) {
    if let Some(frame) = frame() {
        match opaque::flag() {
            true => master.on_frame(now(), &frame),
            false => master.on_displaced(now(), &frame),
        }
    }
    let kind = opaque::pick([BusErrorKind::Overrun, BusErrorKind::Other]);
    consume(master.send(now(), &mut AnySink { any: frame }));
    master.on_receive_error(now(), kind);
}

fn commands(master: &mut ServoMaster<AXES>) {
    match opaque::byte() {
        0 => consume(master.enable(now(), group())),
        1 => consume(master.resume(now(), group())),
        2 => master.stop(now(), group()),
        3 => master.halt(now(), group()),
        4 => master.disable(now(), group()),
        5 => consume(master.clear(now(), group())),
        6 => consume(master.adopt(now(), group())),
        7 => consume(master.start_move(now(), word() as usize, drive_move())),
        8 => {
            let moves = [(); AXES].map(|()| (word() as usize, drive_move()));
            consume(master.start_moves(now(), &moves));
        }
        _ => {
            let confirmation = opaque::pick([Confirmation::None, Confirmation::Given]);
            let Some(procedure) = procedure() else { return };
            consume(master.start(now(), word() as usize, procedure, confirmation));
        }
    }
}

/// Any motion of a drive by itself.
pub(crate) fn drive_move() -> DriveMove {
    match opaque::byte() {
        0 => DriveMove::To(opaque::number()),
        1 => DriveMove::By(opaque::number()),
        2 => DriveMove::Speed(opaque::number()),
        _ => DriveMove::Wave {
            shape: opaque::pick([WaveShape::Square, WaveShape::Sine]),
            amplitude: opaque::number(),
            frequency_hz: opaque::number(),
        },
    }
}

fn drive_curve() -> Option<dyn_can::ParamGroup2> {
    Some(dyn_can::ParamGroup2 {
        max_speed: dyn_can::MaxSpeed::new(opaque::number()).ok()?,
        max_acceleration: dyn_can::MaxAcceleration::new(opaque::number()).ok()?,
    })
}

/// Any procedure.
pub(crate) fn procedure() -> Option<Procedure> {
    Some(match request()? {
        Request::ReadDriveId => Procedure::ReadDriveId,
        Request::ReadDriveConfig => Procedure::ReadConfig,
        Request::ReadParamGroup1 => Procedure::ReadGroup1,
        Request::ReadParamGroup2 => Procedure::ReadGroup2,
        Request::ReadParamGroup3 => Procedure::ReadGroup3,
        Request::SetDriveConfig(config) => Procedure::WriteConfig(config),
        Request::SetParamGroup1(group) => Procedure::WriteGroup1(group),
        Request::SetParamGroup2(group) => Procedure::WriteGroup2(group),
        Request::SetParamGroup3(group) => Procedure::WriteGroup3(group),
        Request::SetOrigin => Procedure::SetOrigin,
        Request::DriveReset => Procedure::DriveReset,
        _ => return None,
    })
}

fn look(master: &mut ServoMaster<AXES>) {
    consume(master.snapshot(word() as usize));
    consume(master.facts(word() as usize));
    consume(master.may_leave(word() as usize, opaque::pick(Class::ALL)));
    consume(master.cycle_counters());
    consume(master.next_event());
    consume(master.poll_at());
    consume(master.changes());
    consume(master.all_are(group(), AxisState::Streaming));
}

/// Any keyframes.
pub(crate) fn keyframes() -> [Keyframe<2>; 4] {
    [(); 4].map(|()| Keyframe {
        at_ms: word(),
        positions_counts: [opaque::number(), opaque::number()],
    })
}

fn motion() {
    let keyframes = keyframes();
    let given = keyframes.get(..word() as usize).unwrap_or(&keyframes);
    let motion = match KeyframeMotion::new(given) {
        Ok(motion) => motion,
        Err(error) => return consume(error),
    };
    consume(motion.position(opaque::bits()));
    consume(motion.duration_us());
    consume(motion.peak_step_counts(word()));
}
