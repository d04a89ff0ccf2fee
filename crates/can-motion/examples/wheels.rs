//! Two hub motors on a virtual bus: set-up, enable, speeds, events, stop, disable.
//! `cargo run -p can-motion --features zlac --example wheels`

use can_motion::wheel::{WheelConfig, WheelLimits, WheelMaster, WheelMasterConfig, WheelMode};
use can_motion::{AxisState, GroupId, Instant, service};
use drive_sim::{Bench, BitRate, Bus, ControllerConfig, TxOrder, ZlacDrive, ZlacDriveConfig};
use zlac8030l::NodeId;

const GROUP: GroupId = GroupId(0);
/// 100 Hz at 500 kbit/s, as `WheelMasterConfig::DEFAULT` says.
const CYCLE_US: u64 = 10_000;

fn main() -> Result<(), Box<dyn std::error::Error>> {
    let nodes = [NodeId::new(1)?, NodeId::new(2)?];
    // At most 60 r/min, changing by 2 r/min in a cycle.
    let limits = WheelLimits::speed(60, 2);
    let wheels = nodes.map(|node| WheelConfig::new(node, WheelMode::Velocity, limits));
    let mut bench: Bench<ZlacDrive> = Bench::new(Bus::new(BitRate::Kbit500));
    let port = bench.add_master(ControllerConfig::bxcan(TxOrder::Fifo));
    for node in nodes {
        let drive = ZlacDrive::new(ZlacDriveConfig::new(node));
        bench.add_device(drive, ControllerConfig::device());
    }
    let mut master = WheelMaster::<2>::new(WheelMasterConfig::DEFAULT, &wheels)?;
    for cycle in 0..900_u64 {
        let now = Instant::from_us(bench.now_ns() / 1_000);
        if master.all_are(GROUP, AxisState::Ready) && cycle < 800 {
            master.enable(now, GROUP)?;
        } else if master.all_are(GROUP, AxisState::Streaming) && cycle < 600 {
            // On the spot.
            master.set_target(0, 60)?;
            master.set_target(1, -60)?;
        }
        match cycle {
            600 => master.stop(now, GROUP),
            800 => master.disable(now, GROUP),
            _ => {}
        }
        master.begin_cycle(now);
        let end_ns = (cycle + 1) * CYCLE_US * 1_000;
        loop {
            let now = Instant::from_us(bench.now_ns() / 1_000);
            let _ = service(&mut master, &mut bench.port(port), now);
            if !bench.step_to(end_ns) {
                break;
            }
        }
        while let Some(event) = master.next_event() {
            println!("{} s, wheel {:?}: {:?}", event.at, event.axis, event.kind);
        }
    }
    let targets = [0, 1].map(|axis| master.snapshot(axis).map(|wheel| wheel.counters.set_points));
    println!("frames of a cycle: {targets:?}");
    assert!(master.all_are(GROUP, AxisState::Ready));
    Ok(())
}
