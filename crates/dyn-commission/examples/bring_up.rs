//! A lone fresh drive gets its first id, then it is scanned for and read. `cargo run -p dyn-commission --example bring_up`

use bus_user::{Instant, service};
use drive_sim::{Bench, BitRate, Bus, ControllerConfig, DynDrive, DynDriveConfig, NodeId, TxOrder};
use dyn_can::{DriveId, Revision};
use dyn_commission::{AssignId, AssignResult, Commissioner, Scan, Script};

/// Runs one task of commissioning to its end.
fn run<S: Script>(bench: &mut Bench<DynDrive>, port: NodeId, script: S) -> Option<S::Result>
where
    S::Result: Clone,
{
    let mut task = Commissioner::new(script);
    // At most five seconds of virtual time: a scan listens 20 ms for each of 63 ids.
    for _ in 0..20_000 {
        let now = Instant::from_us(bench.now_ns() / 1_000);
        task.tick(now);
        let _ = service(&mut task, &mut bench.port(port), now);
        if let Some(result) = task.result() {
            return Some(result.clone());
        }
        bench.advance_to(bench.now_ns() + 250_000);
    }
    None
}

fn main() -> Result<(), Box<dyn std::error::Error>> {
    let mut bench = Bench::new(Bus::new(BitRate::Kbit1000));
    let port = bench.add_master(ControllerConfig::bxcan(TxOrder::Fifo));
    // The only drive on the bus, as it comes out of its box: it answers to identifier 0, and so would every other.
    let fresh = DynDriveConfig::fresh().with_revision(Revision::V1_2A);
    bench.add_device(DynDrive::new(fresh), ControllerConfig::device());
    bench.advance_to(200_000_000);

    let id = DriveId::new(5)?;
    let script = AssignId::first_id_of_the_only_drive(id);
    let assigned = run(&mut bench, port, script);
    println!("id {id}: {assigned:?}");
    assert_eq!(assigned, Some(AssignResult::Active));

    let found = run(&mut bench, port, Scan::default()).unwrap_or_default();
    for drive in &found {
        println!(
            "found drive {} of revision {:?}",
            drive.drive, drive.revision
        );
    }
    assert_eq!(found.len(), 1);
    Ok(())
}
