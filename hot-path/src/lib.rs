//! What every cycle does, a known number of times.
//!
//! The images in `src/bin` do it and go to sleep; `cargo xtask cost` runs each with [`CALLS`] and with twice as many calls on the
//! emulated board. The difference of their instructions is the cost of the calls alone.
#![no_std]
#![forbid(unsafe_code)]

mod drives;
pub mod floor;
pub mod path;
pub mod trajectory;

use core::hint::black_box;

use can_motion::{
    AxisConfig, BusUser, GroupId, Instant, Limits, MasterConfig, Outcome, PollPeriods, ServoMaster,
    StepChange, Travel,
};
use dyn_can::{
    Address, ByteOrder, DataFrame, Dialect, DriveId, GearNumber, PdStep, Reply, ReplyKind,
    StepLimit, go_relative_pos_pd,
};

use drives::Drives;

/// Calls of one image.
pub const CALLS: u32 = if cfg!(feature = "twice") {
    2_000
} else {
    1_000
};

/// Cycle of the masters.
const CYCLE_US: u32 = 1_000;

/// What the images print where they are built for the host.
pub const HOST_MESSAGE: &str = "this image is for the target: cargo xtask cost";

/// The loop and its inputs alone, to take off from the codec's counts.
pub fn nothing() {
    for call in 0..CALLS {
        let _ = black_box(black_box(call as i32));
    }
}

/// One streamed set-point, range checked.
pub fn encode() {
    for call in 0..CALLS {
        if let Ok(step) = PdStep::new(black_box(call as i32)) {
            black_box(go_relative_pos_pd(DriveId::MIN, step, ByteOrder::MsbFirst));
        }
    }
}

/// One position reply of `N` data bytes with every check (function, number of bytes, form, range), and the two values that a caller wants
/// of it.
pub fn decode<const N: usize>() {
    let Ok(frame) = DataFrame::new(0x02E, &[0x02; N]) else {
        return;
    };
    for _ in 0..CALLS {
        let decoded = Reply::decode(
            black_box(&frame),
            Some(ReplyKind::Position),
            black_box(&Dialect::V1_6A),
        );
        match decoded {
            Ok((address, Reply::Position(counts))) => {
                black_box((address, counts));
            }
            other => {
                let _ = black_box(other);
            }
        }
    }
}

/// The loop of [`decode`] with the inputs and the results of the same types, to take off from its counts.
pub fn decode_nothing() {
    let Ok(frame) = DataFrame::new(0x02E, &[0x02; 4]) else {
        return;
    };
    for _ in 0..CALLS {
        black_box(&Dialect::V1_6A);
        let address = core::ptr::from_ref(black_box(&frame)).addr();
        black_box((Address::Broadcast, address as i32));
    }
}

/// The core of the master with `N` streaming axes: targets in, frames out.
pub fn master<const N: usize>() {
    let Some((mut master, mut now)) = streaming::<N>() else {
        return;
    };
    for call in 0..CALLS {
        now = now + CYCLE_US;
        cycle(&mut master, now, black_box(call as i32), &mut |frame| {
            black_box(frame);
        });
    }
}

/// One cycle of streaming axes with a new target for each; every frame is accepted.
fn cycle<const N: usize>(
    master: &mut ServoMaster<N>,
    now: Instant,
    target_counts: i32,
    hear: &mut impl FnMut(&DataFrame),
) {
    for axis in 0..N {
        let _ = black_box(master.set_target(axis, target_counts));
    }
    master.begin_cycle(now);
    let _ = master.send(now, &mut |frame: &DataFrame| {
        hear(frame);
        Outcome::Accepted
    });
}

/// A master with `N` streaming axes and no polls, and its latest cycle; `None` when it did not come to that.
fn streaming<const N: usize>() -> Option<(ServoMaster<N>, Instant)> {
    let mut drives = DriveId::all();
    let limits = Limits::new(StepLimit::MAX, StepChange::MAX, Travel::WHOLE);
    let axes = [(); N].map(|()| AxisConfig {
        polls: PollPeriods::OFF,
        unwatched: true,
        ..AxisConfig::new(
            drives.next().unwrap_or(DriveId::MIN),
            GearNumber::MAX,
            limits,
        )
    });
    let mut master = ServoMaster::<N>::new(MasterConfig::DEFAULT, &axes).ok()?;
    let mut answers = Drives::default();
    for cycle in 0..5_000 {
        let now = Instant::from_us(cycle * u64::from(CYCLE_US));
        // Refused until every axis is ready, and once it streams.
        let _ = master.enable(now, GroupId(0));
        master.begin_cycle(now);
        // At most one request a cycle, so at most one reply.
        let mut reply = None;
        let _ = master.send(now, &mut |frame: &DataFrame| {
            reply = answers.reply(frame).or(reply);
            Outcome::Accepted
        });
        if let Some(reply) = reply {
            master.on_frame(now, &reply);
        }
        if master.all_are(GroupId(0), can_motion::AxisState::Streaming) {
            return Some((master, now));
        }
        while master.next_event().is_some() {}
    }
    None
}

#[cfg(test)]
mod tests {
    use dyn_can::{DynFrame, FunctionCode};

    use super::*;

    /// The axes must stream while they are counted: without set-points a cycle would be cheap.
    fn set_points<const N: usize>() -> usize {
        let (mut master, mut now) = streaming::<N>().unwrap();
        let mut set_points = 0;
        for call in 0..CALLS {
            now = now + CYCLE_US;
            cycle(&mut master, now, call as i32, &mut |frame| {
                set_points += usize::from(frame.function() == FunctionCode::GoRelativePosPd);
            });
        }
        set_points
    }

    #[test]
    fn every_counted_cycle_sends_a_set_point_to_every_axis() {
        assert_eq!(set_points::<1>(), CALLS as usize);
        assert_eq!(set_points::<8>(), 8 * CALLS as usize);
    }
}
