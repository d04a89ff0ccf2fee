//! One servo axis on a simulated bus, made of the published packages alone.

use can_motion::{
    AxisConfig, AxisState, GroupId, Instant, Limits, MasterConfig, MotorLimits, ServoMaster,
    Travel, service,
};
use drive_sim::{Bench, BitRate, Bus, ControllerConfig, DynDrive, DynDriveConfig, TxOrder};
use dyn_can::{DriveId, GearNumber};

const GROUP: GroupId = GroupId(0);

fn main() -> Result<(), Box<dyn std::error::Error>> {
    let (id, gear) = (DriveId::new(1)?, GearNumber::new(4_096)?);
    let motor = MotorLimits {
        speed_rpm: 60,
        acceleration_rpm_per_s: 600,
    };
    let travel = Travel::of_motor_millidegrees(-180_000, 180_000, gear);
    let config = MasterConfig::DEFAULT;
    let limits = Limits::of_motor(motor, travel, gear, config.cycle_us)?;
    let mut master = ServoMaster::<1>::new(config, &[AxisConfig::new(id, gear, limits)])?;

    let mut bench: Bench<DynDrive> = Bench::new(Bus::new(BitRate::Kbit1000));
    let node = bench.add_master(ControllerConfig::bxcan(TxOrder::Fifo));
    let drive = DynDriveConfig {
        enabled_after_power_on: false,
        ..DynDriveConfig::new(id)
    };
    let drive = bench.add_device(DynDrive::new(drive), ControllerConfig::device());

    let mut counts = 0;
    for cycle in 1..=3_000_u64 {
        let now = Instant::from_us(bench.now_ns() / 1_000);
        if master.all_are(GROUP, AxisState::Ready) && cycle < 2_000 {
            master.enable(now, GROUP)?;
        }
        if master.all_are(GROUP, AxisState::Streaming) && counts < 5_000 {
            counts += 10;
            master.set_target(0, counts)?;
        }
        if cycle == 2_500 {
            master.disable(now, GROUP);
        }
        master.begin_cycle(now);
        loop {
            let now = Instant::from_us(bench.now_ns() / 1_000);
            let _ = service(&mut master, &mut bench.port(node), now);
            if !bench.step_to(cycle * 1_000_000) {
                break;
            }
        }
        while let Some(event) = master.next_event() {
            println!("{} s: {:?}", event.at, event.kind);
        }
    }
    let is_at = bench.device(drive).position_counts(bench.now_ns());
    println!("sent {counts} counts, the motor is at {is_at}");
    assert_eq!((i64::from(counts), is_at), (5_000, 5_000));
    Ok(())
}
