//! A program of G-code as the built-in motion: what the board puts on the bus is what its keyframes say, which a test of `motionctl` compares
//! with the program itself.

use dyn_can::{Address, Dialect, Request};
use firmware_tests::chip::Controller;
use firmware_tests::{Contact, Rig, rig};

/// As the configuration includes it.
mod slot {
    include!("../configs/slot.rs");
}

/// Positions of both drives behind each of their set-points.
fn positions(rig: &Rig, from_ns: u64) -> Vec<[i64; 2]> {
    let mut drives = [vec![0_i64], vec![0_i64]];
    for record in rig.set_points_since(from_ns) {
        let frame = dyn_can::DataFrame::from_can(&record.frame).expect("a data frame");
        let decoded = Request::decode(&frame, &Dialect::V1_6A);
        let Ok((Address::Drive(drive), Request::GoRelativePosPd(step))) = decoded else {
            panic!("{decoded:?} is no set-point")
        };
        let drive = &mut drives[usize::from(drive.get()) - 1];
        let last = drive.last().copied().unwrap_or(0);
        drive.push(last + i64::from(i32::from(step.get())));
    }
    let [one, other] = drives;
    one.into_iter()
        .zip(other)
        .map(|(one, other)| [one, other])
        .collect()
}

#[test]
fn the_board_plays_a_program_twice() {
    // The other board has no image of it: the motion is the same code.
    if rig::chip().controller != Controller::BxCan {
        return;
    }
    let mut rig =
        Rig::with_numbered_drives(rig::image("program"), slot::MOTION_DRIVES.len() as i32);
    rig.make_ready();
    rig.enable();
    rig.close(Contact::Run);
    assert!(rig.run_until_logged("the motion starts", 1_000));
    rig.run_ms(4_500);
    assert_eq!(
        (rig.statistic("late"), rig.statistic("missed")),
        (Some(0), Some(0))
    );
    let positions = positions(&rig, 0);
    let duration = usize::try_from(slot::MOTION.duration_us() / 1_000).expect("a short one");
    let expected = |cycle: usize| {
        let us = (cycle % duration) as u64 * 1_000;
        slot::MOTION.position(us).map(i64::from)
    };
    // The drives are held for some cycles before the motion starts.
    let moves = positions.iter().position(|at| *at != [0, 0]);
    let first = (0..duration).find(|cycle| expected(*cycle) != [0, 0]);
    let (Some(moves), Some(first)) = (moves, first) else {
        panic!("nothing moves")
    };
    let played = &positions[moves - first..];
    assert!(played.len() > 2 * duration, "{} cycles", played.len());
    for (cycle, at) in played.iter().enumerate() {
        assert_eq!(*at, expected(cycle), "cycle {cycle}");
    }
}
