//! What one axis of a group means to the other: an alarm of drive 2 stops both in the same cycle; then clear, and what is needed to go on.
//! `cargo run -p can-motion --example group_stop`

use can_motion::{
    AxisConfig, AxisState, GroupId, Instant, Limits, MasterConfig, MotorLimits, ServoMaster,
    Travel, service,
};
use drive_sim::{Bench, BitRate, Bus, ControllerConfig, DynDrive, DynDriveConfig, TxOrder};
use dyn_can::{Alarm, DriveId, GearNumber};

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
    let drives = ids.map(|id| {
        let drive = DynDrive::new(DynDriveConfig::new(id));
        bench.add_device(drive, ControllerConfig::device())
    });
    let mut master = ServoMaster::<2>::new(config, &axes)?;
    let mut sent_at_alarm = None;
    for cycle in 0..2_500_u64 {
        let now = Instant::from_us(bench.now_ns() / 1_000);
        if master.all_are(GROUP, AxisState::FoundOn) && cycle < 1_000 {
            master.adopt(now, GROUP)?;
        } else if master.all_are(GROUP, AxisState::Holding) && cycle < 1_000 {
            master.resume(now, GROUP)?;
        } else if master.all_are(GROUP, AxisState::Streaming) {
            for axis in 0..2 {
                let target = master
                    .snapshot(axis)
                    .map_or(0, |axis| axis.target_counts + 5);
                master.set_target(axis, target)?;
            }
        }
        match cycle {
            1_000 => bench
                .device_mut(drives[1])
                .faults_mut()
                .raise_alarm(Alarm::OverCurrent),
            1_010 => {
                let sent = [0, 1].map(|axis| master.snapshot(axis).map(|axis| axis.sent_counts));
                sent_at_alarm = Some(sent);
            }
            // The cause is removed, here by a power cycle; `clear` moves nothing and switches nothing.
            1_500 => bench
                .device_mut(drives[1])
                .faults_mut()
                .power_cycle(100_000_000),
            2_000 => master.clear(now, GROUP)?,
            _ => {}
        }
        master.begin_cycle(now);
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
    println!("after the alarm {sent_at_alarm:?}, in the end {sent:?}");
    assert_eq!(
        sent_at_alarm,
        Some(sent),
        "nothing moves until the application says so"
    );
    // Axis 0 holds; the drive of axis 1 came up with its servo on, and nobody has decided about it yet.
    let states = axes.map(|axis| axis.map(|axis| axis.state));
    assert_eq!(states, [Some(AxisState::Holding), Some(AxisState::FoundOn)]);
    Ok(())
}
