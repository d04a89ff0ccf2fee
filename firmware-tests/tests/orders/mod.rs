//! What the tests of the image that takes orders share.
#![allow(dead_code, reason = "each test uses a part")]

use std::path::Path;

use board_link::segment::{AxisSegment, Segment, Shape};
use board_settings::Settings;
use dyn_can::{DataFrame, Dialect, Request};
use firmware_tests::host::Host;
use firmware_tests::motion_file::MotionFile;
use firmware_tests::records::{bytes_of, settings_of};
use firmware_tests::{Rig, rig};
use trajectory::Time;

pub(crate) const AXES: usize = 4;
/// The limits of the axes: counts per cycle, 600 r/min, and per cycle², 8000 r/min per second.
pub(crate) const VELOCITY: i32 = 163;
const ACCELERATION: f64 = 2.184;

/// A board with settings for [`AXES`], just started.
pub(crate) fn board() -> (Rig, Host) {
    with_settings()
}

/// Four axes with the limits above, and no ends.
pub(crate) fn settings() -> Settings {
    firmware_tests::orders::settings(AXES as u8)
}

/// A board with these settings in its flash.
pub(crate) fn with_settings() -> (Rig, Host) {
    let mut rig = Rig::with_numbered_drives(rig::image("link"), AXES as i32);
    let content = rig.board().soc().flash.content().clone();
    let mut records = settings_of(content, rig::chip());
    records.append(&bytes_of(&settings())).unwrap();
    let content = records.flash().content();
    rig.board_mut().set_flash_content(content);
    let host = Host::new(&mut rig, 1);
    (rig, host)
}

/// A board without settings, just started.
pub(crate) fn new() -> Rig {
    Rig::with_numbered_drives(rig::image("link"), AXES as i32)
}

pub(crate) fn pick_and_place() -> MotionFile {
    let path = Path::new(env!("CARGO_MANIFEST_DIR")).join("../examples/pick-and-place.csv");
    MotionFile::read(&path)
}

/// Two long segments, from rest to rest: three seconds there, three back.
pub(crate) fn forth_and_back(stand: &[i32]) -> Vec<Segment> {
    let to = |way: i32| Segment {
        duration: Time::from_cycles(3_000).ticks(),
        axes: stand
            .iter()
            .map(|stand| AxisSegment {
                end: i64::from(stand + way) << 24,
                shape: Shape::MinimumJerk,
            })
            .collect(),
    };
    vec![to(40_000), to(0)]
}

pub(crate) fn targets(host: &Host) -> Vec<i32> {
    host.snapshot.axes.iter().map(|axis| axis.target).collect()
}

/// The counts that each drive was told since `from_ns`, after each set-point: one in each cycle.
pub(crate) fn counts_told(rig: &Rig, from_ns: u64) -> Vec<Vec<i32>> {
    let mut told = vec![Vec::new(); AXES];
    for record in rig.set_points_since(from_ns) {
        let frame = DataFrame::from_can(&record.frame).unwrap();
        match Request::decode(&frame, &Dialect::V1_6A) {
            Ok((address, Request::GoRelativePosPd(step))) => {
                let drive = address.drive().unwrap();
                let told: &mut Vec<i32> = &mut told[drive.get() as usize - 1];
                let before = told.last().copied().unwrap_or(0);
                told.push(before + i32::from(step.get()));
            }
            other => panic!("{other:?} is no set-point"),
        }
    }
    told
}

/// Looks at the set-points on the bus from a time on.
pub(crate) struct Judge {
    from_ns: u64,
}

impl Judge {
    pub(crate) fn from_now(rig: &Rig) -> Self {
        Self {
            from_ns: rig.board().soc().now_ns(),
        }
    }

    /// Whether the latest set-points have moved an axis.
    pub(crate) fn is_moving(&self, rig: &Rig) -> bool {
        let since_ns = self.from_ns.max(rig.board().soc().now_ns() - 5_000_000);
        let told = counts_told(rig, since_ns);
        told.iter().flatten().any(|counts| *counts != 0)
    }

    /// Lets a stream begin, until an axis moves as fast as it will.
    pub(crate) fn wait_for_motion(&self, rig: &mut Rig, host: &mut Host) {
        let moves = host.run_until(rig, 3_000, |_, rig| self.is_moving(rig));
        assert!(moves, "{:?} {:#?}", host.told, rig.board().log());
        host.run_ms(rig, 300);
        assert!(self.is_moving(rig));
    }

    /// Every step and every change of it within the limits, but for whole counts; returns how far each axis went.
    pub(crate) fn check_limits(&self, rig: &Rig) -> Vec<i32> {
        let told = counts_told(rig, self.from_ns);
        for (axis, told) in told.iter().enumerate() {
            let steps: Vec<i32> = told.windows(2).map(|pair| pair[1] - pair[0]).collect();
            let fastest = steps.iter().map(|step| step.abs()).max().unwrap_or(0);
            assert!(fastest <= VELOCITY, "axis {axis}: {fastest} counts");
            // Over ten cycles rounding is a fifth of a count per cycle.
            for window in steps.windows(11) {
                let change = f64::from(window[10] - window[0]).abs();
                assert!(
                    change <= 10.0 * ACCELERATION + 2.0,
                    "axis {axis}: {change} in ten cycles, {window:?}"
                );
            }
        }
        told.iter()
            .map(|told| told.last().copied().unwrap_or(0))
            .collect()
    }
}
