//! Two servo axes on a virtual bus: take over, wait, stream, events, stop, disable. `cargo run -p can-motion --example servo`
//!
//! On a board only `Bench` changes: `service` takes any `embedded_can::nb::Can`.

use can_motion::{
    AxisConfig, AxisState, GroupId, Instant, Limits, MasterConfig, MotorLimits, ServoMaster,
    Travel, service,
};
use drive_sim::{Bench, BitRate, Bus, ControllerConfig, DynDrive, DynDriveConfig, TxOrder};
use dyn_can::{DriveId, GearNumber};

const GROUP: GroupId = GroupId(0);
const CYCLE_US: u64 = 1_000;

fn main() -> Result<(), Box<dyn std::error::Error>> {
    let gear = GearNumber::new(4_096)?;
    // Slow, and half a turn either way: what the machine may do is for its builder to say.
    let motor = MotorLimits {
        speed_rpm: 60,
        acceleration_rpm_per_s: 600,
    };
    let travel = Travel::of_motor_millidegrees(-180_000, 180_000, gear);
    let config = MasterConfig::DEFAULT;
    let limits = Limits::of_motor(motor, travel, gear, config.cycle_us)?;
    let ids = [DriveId::new(1)?, DriveId::new(2)?];
    let axes = ids.map(|id| AxisConfig::new(id, gear, limits));

    let mut bench: Bench<DynDrive> = Bench::new(Bus::new(BitRate::Kbit1000));
    let node = bench.add_master(ControllerConfig::bxcan(TxOrder::Fifo));
    for id in ids {
        bench.add_device(
            DynDrive::new(DynDriveConfig::new(id)),
            ControllerConfig::device(),
        );
    }
    let mut master = ServoMaster::<2>::new(config, &axes)?;
    let mut started_at = None;
    for cycle in 0..3_000_u64 {
        let now = Instant::from_us(bench.now_ns() / 1_000);
        if master.all_are(GROUP, AxisState::FoundOn) {
            // Drives come up with their servo on: take them over as they are.
            master.adopt(now, GROUP)?;
        } else if master.all_are(GROUP, AxisState::Ready) && cycle < 2_500 {
            master.enable(now, GROUP)?;
        } else if master.all_are(GROUP, AxisState::Holding) && started_at.is_none() {
            master.resume(now, GROUP)?;
            started_at = Some(cycle);
        } else if let Some(start) = started_at
            && master.all_are(GROUP, AxisState::Streaming)
            && cycle < 2_000
        {
            // A steady 10 counts a cycle, within the 16 that 60 r/min allow.
            let counts = ((cycle - start) * 10).min(8_000) as i32;
            master.set_target(0, counts)?;
            master.set_target(1, -counts)?;
        }
        match cycle {
            2_000 => master.stop(now, GROUP),
            2_500 => master.disable(now, GROUP),
            _ => {}
        }
        master.begin_cycle(now);
        // On a board: from the interrupts of the controller, until the next cycle.
        let end_ns = (cycle + 1) * CYCLE_US * 1_000;
        loop {
            let now = Instant::from_us(bench.now_ns() / 1_000);
            let _ = service(&mut master, &mut bench.port(node), now);
            if !bench.step_to(end_ns) {
                break;
            }
        }
        while let Some(event) = master.next_event() {
            println!("{} s, axis {:?}: {:?}", event.at, event.axis, event.kind);
        }
    }
    let axes = [0, 1].map(|axis| master.snapshot(axis));
    let sent = axes.map(|axis| axis.map(|axis| axis.sent_counts));
    println!("sent in the end: {sent:?}");
    assert!(master.all_are(GROUP, AxisState::Ready) && sent[0] == sent[1].map(|counts| -counts));
    Ok(())
}
