//! The image that `cargo fw` builds, from power-on to streaming.

use firmware_tests::{Rig, Stop, rig};

fn started() -> Rig {
    let image = rig::image("FIRMWARE_IMAGE", "motion-board").expect("the image is built");
    Rig::with_numbered_drives(image, 2)
}

#[test]
fn it_probes_and_anchors_both_drives_and_streams() {
    let mut rig = started();
    assert_eq!(rig.run_ms(1_500), Stop::Limit);
    assert!(rig.has_logged("on the bus"));
    assert!(rig.has_logged("1000 cycles, 0 late, 0 missed"));
    for drive in rig.wire().devices() {
        assert!(drive.is_enabled());
        assert!(drive.books().pd_frames > 1_000);
        assert_eq!(drive.books().pd_frames_ignored, 0);
    }
}

#[test]
fn two_runs_are_the_same_to_the_instruction() {
    let run = || {
        let mut rig = started();
        let mut instructions = Vec::new();
        for _ in 0..400 {
            rig.run_ms(1);
            instructions.push(rig.board().soc().instructions);
        }
        let traffic: Vec<_> = rig.wire().bus().log().iter().copied().collect();
        (instructions, traffic, rig.board().log().to_vec())
    };
    assert!(run() == run());
}
