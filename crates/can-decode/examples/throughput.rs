//! How much faster than a full 1 Mbit/s bus the decoder is, from the text of a log to the text of its meaning.
//!
//! `cargo run --release -p can-decode --example throughput`
//!
//! The log holds frames back to back with their exact length on the wire, so its time is that of a bus with 100 % load: 14 drives with
//! a set-point each, and status and position of every drive, asked and answered.

use std::fmt::Write as _;
use std::time::Instant;

use can_decode::log::{Event, LogReader};
use can_decode::statistics::Statistics;
use can_decode::{Decoder, Frame};
use drive_sim::WireLength;
use embedded_can::{Frame as _, StandardId};

const DRIVES: u16 = 14;
const ROUNDS: u16 = 4_000;
/// One bit at 1 Mbit/s.
const BIT_NS: u64 = 1_000;

fn main() -> Result<(), Box<dyn std::error::Error>> {
    let (log, bus_s) = full_bus_log()?;
    println!(
        "{} lines, {bus_s:.2} s of a bus with 100 % load",
        log.lines().count()
    );
    for (what, run) in [
        ("read", read as fn(&str) -> Result<u64, _>),
        ("read and decode", decode),
        ("read, decode, write words", write_words),
        ("read, decode, write JSON", write_json),
    ] {
        let started = Instant::now();
        let result = run(&log)?;
        let times = bus_s / started.elapsed().as_secs_f64();
        println!("{what:26} {times:6.0} times real time ({result} frames or bytes)");
    }
    Ok(())
}

/// A log and its time in seconds.
fn full_bus_log() -> Result<(String, f64), Box<dyn std::error::Error>> {
    let (mut log, mut at_ns) = (String::new(), 0);
    let mut push = |id: u16, data: &[u8]| {
        let id = StandardId::new(id).ok_or("an 11-bit identifier")?;
        let frame = drive_sim::Frame::new(id, data).ok_or("a frame")?;
        at_ns += u64::from(WireLength::of(&frame).bits_with_ifs) * BIT_NS;
        let us = at_ns / 1_000;
        writeln!(
            log,
            "({}.{:06}) can0 {frame}",
            us / 1_000_000,
            us % 1_000_000
        )?;
        Ok::<(), Box<dyn std::error::Error>>(())
    };
    for round in 0..ROUNDS {
        for drive in 1..=DRIVES {
            push(drive << 5 | 0x1C, &round.wrapping_mul(37).to_be_bytes())?;
        }
        for drive in 1..=DRIVES {
            push(drive << 5 | 0x09, &[])?;
            push(drive << 5 | 0x09, &[0x01])?;
            push(drive << 5 | 0x0E, &[0x1B])?;
            push(drive << 5 | 0x0E, &(i32::from(round) * 1_000).to_be_bytes())?;
        }
    }
    Ok((log, at_ns as f64 * 1e-9))
}

type Outcome = Result<u64, Box<dyn std::error::Error>>;

fn each_frame(
    log: &str,
    mut each: impl FnMut(u64, &Frame) -> Result<(), std::fmt::Error>,
) -> Result<(), Box<dyn std::error::Error>> {
    let mut reader = LogReader::new();
    for line in log.lines() {
        let Some(entry) = reader.line(line)? else {
            continue;
        };
        if let Event::Frame(frame) = entry.event {
            each(entry.at_ns.unwrap_or_default(), &frame)?;
        }
    }
    Ok(())
}

fn read(log: &str) -> Outcome {
    let mut frames = 0;
    each_frame(log, |_, _| {
        frames += 1;
        Ok(())
    })?;
    Ok(frames)
}

fn decode(log: &str) -> Outcome {
    let (mut decoder, mut statistics) = (Decoder::default(), Statistics::default());
    each_frame(log, |at_ns, frame| {
        let meaning = decoder.hear(at_ns, frame);
        statistics.count(at_ns, frame, &meaning);
        Ok(())
    })?;
    Ok(statistics.frames())
}

fn write_words(log: &str) -> Outcome {
    let (mut decoder, mut text, mut bytes) = (Decoder::default(), String::new(), 0);
    each_frame(log, |at_ns, frame| {
        text.clear();
        writeln!(text, "{at_ns} {frame:28} {}", decoder.hear(at_ns, frame))?;
        bytes += text.len() as u64;
        Ok(())
    })?;
    Ok(bytes)
}

fn write_json(log: &str) -> Outcome {
    let (mut decoder, mut text, mut bytes) = (Decoder::default(), Vec::new(), 0);
    each_frame(log, |at_ns, frame| {
        text.clear();
        let meaning = decoder.hear(at_ns, frame);
        // Writing to memory cannot fail, and every key is a string.
        serde_json::to_writer(&mut text, &meaning).map_err(|_| std::fmt::Error)?;
        bytes += text.len() as u64;
        Ok(())
    })?;
    Ok(bytes)
}
