//! A servo on a virtual bus goes to a position by itself, then streams from there. `cargo run -p can-motion --example point_to_point`

use can_motion::{
    AxisConfig, AxisState, Confirmation, DriveMove, EventKind, GroupId, Instant, Limits,
    MasterConfig, MotorLimits, Procedure, ProcedureEnd, Reason, ServoMaster, Travel, service,
};
use drive_sim::{Bench, BitRate, Bus, ControllerConfig, DynDrive, DynDriveConfig, NodeId, TxOrder};
use dyn_can::{DriveId, GearNumber, MaxAcceleration, MaxSpeed, ParamGroup2};

const GROUP: GroupId = GroupId(0);
const CYCLE_US: u64 = 1_000;

struct Rig {
    bench: Bench<DynDrive>,
    node: NodeId,
    master: ServoMaster<1>,
    cycle: u64,
}

impl Rig {
    fn now(&self) -> Instant {
        Instant::from_us(self.bench.now_ns() / 1_000)
    }

    /// One cycle; on a board only this changes.
    fn cycle(&mut self) {
        self.cycle += 1;
        let end_ns = self.cycle * CYCLE_US * 1_000;
        let now = self.now();
        self.master.begin_cycle(now);
        loop {
            let now = self.now();
            let _ = service(&mut self.master, &mut self.bench.port(self.node), now);
            if !self.bench.step_to(end_ns) {
                return;
            }
        }
    }

    /// Cycles until an event comes that is meant.
    fn until(&mut self, what: &str, is_meant: impl Fn(&EventKind) -> bool) {
        for _ in 0..10_000 {
            self.cycle();
            while let Some(event) = self.master.next_event() {
                println!("{} s: {:?}", event.at, event.kind);
                if is_meant(&event.kind) {
                    return;
                }
            }
        }
        panic!("{what} does not come");
    }

    fn until_state(&mut self, wanted: AxisState) {
        self.until(
            &wanted.to_string(),
            |kind| matches!(kind, EventKind::State { to, .. } if *to == wanted),
        );
    }
}

fn main() -> Result<(), Box<dyn std::error::Error>> {
    let gear = GearNumber::new(4_096)?;
    let id = DriveId::new(1)?;
    // A turn either way; 60 r/min, and 636 r/min per second are the least that the parameters of a drive can say.
    let motor = MotorLimits {
        speed_rpm: 60,
        acceleration_rpm_per_s: 700,
    };
    let travel = Travel::of_motor_millidegrees(-360_000, 360_000, gear);
    let config = MasterConfig::DEFAULT;
    let limits = Limits::of_motor(motor, travel, gear, config.cycle_us)?;
    let mut bench: Bench<DynDrive> = Bench::new(Bus::new(BitRate::Kbit1000));
    let node = bench.add_master(ControllerConfig::bxcan(TxOrder::Fifo));
    let drive = DynDriveConfig {
        group2: ParamGroup2 {
            max_speed: MaxSpeed::new(5)?,
            max_acceleration: MaxAcceleration::MIN,
        },
        ..DynDriveConfig::new(id)
    };
    let device = bench.add_device(DynDrive::new(drive), ControllerConfig::device());
    let master = ServoMaster::new(config, &[AxisConfig::new(id, gear, limits)])?;
    let mut rig = Rig {
        bench,
        node,
        master,
        cycle: 0,
    };
    rig.until_state(AxisState::FoundOn);
    rig.master.adopt(rig.now(), GROUP)?;
    rig.until_state(AxisState::Holding);
    // Speed and acceleration of the move are those of the drive: they must be known, and within the limits.
    rig.master
        .start(rig.now(), 0, Procedure::ReadGroup2, Confirmation::None)?;
    rig.until("the parameters", |kind| {
        matches!(kind, EventKind::Procedure(ProcedureEnd::Read(_)))
    });
    rig.master.start_move(rig.now(), 0, DriveMove::To(8_192))?;
    rig.until("the end of the move", |kind| {
        matches!(
            kind,
            EventKind::State {
                to: AxisState::Holding,
                reason: Reason::MoveEnded,
                ..
            }
        )
    });
    rig.master.resume(rig.now(), GROUP)?;
    rig.until_state(AxisState::Streaming);
    for step in 1..=500 {
        rig.master.set_target(0, 8_192 - step * 10)?;
        rig.cycle();
    }
    rig.master.stop(rig.now(), GROUP);
    rig.until_state(AxisState::Holding);
    (0..300).for_each(|_| rig.cycle());
    let at_ns = rig.bench.now_ns();
    let position = rig.bench.device(device).position_counts(at_ns);
    println!("in the end at {position}");
    let sent = rig
        .master
        .snapshot(0)
        .map(|axis| i64::from(axis.sent_counts));
    assert_eq!(Some(position), sent);
    rig.master.disable(rig.now(), GROUP);
    rig.until_state(AxisState::Ready);
    Ok(())
}
