//! Virtual seconds per real second: eight simulated drives, streamed at 1 kHz and polled, on a 1 Mbit/s bus.
//!
//! `cargo run --release -p drive-sim --example throughput`

use std::time::Instant;

use drive_sim::{
    Bench, BitRate, ControllerConfig, DynDrive, DynDriveConfig, Frame, NodeId, TxOrder,
};
use dyn_can::{Address, ByteOrder, Dialect, DriveId, PdStep, ReadSelector, Request};
use embedded_can::nb::Can;

const DRIVES: i32 = 8;
const CYCLE_NS: u64 = 1_000_000;
const START_NS: u64 = 150_000_000;
const CYCLES: u64 = 20_000;
/// Counts a cycle: 366 rpm at gear number 4096.
const STEP: i32 = 100;

fn main() -> Result<(), Box<dyn std::error::Error>> {
    let configs: Result<Vec<_>, _> = (1..=DRIVES).map(DynDriveConfig::numbered).collect();
    let (mut bench, drives) = Bench::with_drives(BitRate::Kbit1000, configs?);
    let master = bench.add_master(ControllerConfig {
        tx: drive_sim::TxQueue::Unbounded,
        ..ControllerConfig::bxcan(TxOrder::Fifo)
    });
    let started = Instant::now();
    let mut replies = 0_u64;
    for cycle in 0..CYCLES {
        bench.advance_to(START_NS + cycle * CYCLE_NS);
        replies += read_all(&mut bench, master);
        send_cycle(&mut bench, master, cycle)?;
    }
    let real_s = started.elapsed().as_secs_f64();
    let virtual_s = (CYCLES * CYCLE_NS) as f64 * 1e-9;
    let now_ns = bench.now_ns();
    for drive in drives {
        let drive = bench.device(drive);
        println!(
            "drive {}: commanded {}, position {}, {:.0} rpm",
            drive.config().id.get(),
            drive.commanded_counts(),
            drive.position_counts(now_ns),
            drive.speed_rpm(now_ns)
        );
    }
    println!("{replies} replies");
    println!(
        "{virtual_s} s in {real_s:.3} s: {:.0} virtual seconds per second",
        virtual_s / real_s
    );
    Ok(())
}

/// A set-point for every drive, then one poll in turn.
fn send_cycle(
    bench: &mut Bench<DynDrive>,
    master: NodeId,
    cycle: u64,
) -> Result<(), Box<dyn std::error::Error>> {
    let step = PdStep::new(STEP)?;
    for number in 1..=DRIVES {
        let frame = dyn_can::go_relative_pos_pd(DriveId::new(number)?, step, ByteOrder::MsbFirst);
        send(bench, master, frame.to_can())?;
    }
    let polled = DriveId::new((cycle % DRIVES as u64) as i32 + 1)?;
    let poll = if (cycle / DRIVES as u64).is_multiple_of(2) {
        Request::ReadDriveStatus
    } else {
        Request::GeneralRead(ReadSelector::Position)
    };
    let frame = poll.encode(Address::Drive(polled), &Dialect::V1_6A)?;
    send(bench, master, frame.to_can())
}

fn send(
    bench: &mut Bench<DynDrive>,
    master: NodeId,
    frame: Option<Frame>,
) -> Result<(), Box<dyn std::error::Error>> {
    let frame = frame.ok_or("a data frame is always a frame of the bus")?;
    bench
        .port(master)
        .transmit(&frame)
        .map_err(|error| format!("transmit refused: {error:?}"))?;
    Ok(())
}

fn read_all(bench: &mut Bench<DynDrive>, master: NodeId) -> u64 {
    let mut port = bench.port(master);
    core::iter::from_fn(|| port.receive().ok()).count() as u64
}
