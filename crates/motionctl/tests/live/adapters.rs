//! Every kind of adapter under the commands that people use: the drives behind it count what reaches them.

use std::io::{BufRead, BufReader};
use std::time::Duration;

use serde_json::Value;

use crate::adapter::{DriveEnd, End, FakeAdapter, Manner, Mishap, Stage};
use crate::bench::{Scratch, interrupt, motionctl, status_and_errors};
use crate::undisturbed::undisturbed;

/// Two axes, one turn and half a turn back, in half a second; a turn of the default gear number is 16384 counts.
const MOTION: &str = "time_s,a,b\n0,0,0\n0.25,180,-90\n0.5,360,-180\n";
const COUNTS: [i64; 2] = [16_384, -8_192];

/// How a motion through an adapter may end.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum Motion {
    Completes,
    /// Nobody knows what became of some frames, and there are not enough of them to be noticed for sure.
    MayStop,
    Stops,
}

fn command(adapter: &FakeAdapter, arguments: &[&str]) -> (Option<i32>, String, String) {
    let (name, options) = arguments.split_first().expect("a command");
    let link = [*name, "--slcan", adapter.path()];
    let output = motionctl(&[&link[..], options].concat())
        .output()
        .expect("motionctl runs");
    let (status, errors) = status_and_errors(&output);
    let text = String::from_utf8_lossy(&output.stdout).into_owned();
    (status, text, errors)
}

fn json(text: &str) -> Value {
    serde_json::from_str(text).unwrap_or_else(|_| panic!("{text}"))
}

/// Reads, scans, watches and moves the drives behind an adapter.
fn is_used(name: &str, manner: Manner, motion: Motion) -> End {
    let adapter = FakeAdapter::start(name, manner);
    let (status, text, errors) = command(&adapter, &["read", "--drive", "1", "--json"]);
    assert_eq!(status, Some(0), "{name} read: {errors}");
    assert_eq!(json(&text)["state"]["enabled"], false, "{name}: {text}");
    let (status, text, errors) = command(&adapter, &["scan", "--json"]);
    assert_eq!(status, Some(0), "{name} scan: {errors}");
    let found = json(&text)["drives"].as_array().expect("a list").len();
    assert_eq!(found, 2, "{name} scan: {text}");
    let monitor = ["monitor", "--drives", "1,2", "--count", "3", "--json"];
    let (status, text, errors) = command(&adapter, &monitor);
    assert_eq!(status, Some(0), "{name} monitor: {errors}");
    let last: Vec<Value> = text.lines().rev().take(2).map(json).collect();
    assert_eq!(last.len(), 2, "{name} monitor: {text}");
    for line in last {
        assert_eq!(line["answers"], true, "{name} monitor: {text}");
    }
    moves(name, adapter, motion)
}

/// Moves the drives behind an adapter; every set-point that was counted has reached its drive, once.
fn moves(name: &str, adapter: FakeAdapter, motion: Motion) -> End {
    let file = Scratch::new(&format!("adapter-{name}.csv"), MOTION);
    let run = ["run", "--trajectory", file.path(), "--yes", "--json"];
    let (status, text, errors) = command(&adapter, &run);
    let end = adapter.stop();
    assert_eq!((end.repeated, end.early), (0, 0), "{name}: {end:?}");
    let power = end.drives.map(|drive| drive.enabled);
    assert_eq!(power, [false, true], "{name}: {errors} {end:?}");
    let summary = json(&text);
    let completes = match motion {
        Motion::Completes => true,
        Motion::MayStop => status == Some(0),
        Motion::Stops => false,
    };
    if completes {
        assert_eq!(status, Some(0), "{name}: {errors}{text}");
        let counts = end.drives.map(|drive| drive.counts);
        assert_eq!(counts, COUNTS, "{name}: {text}");
    } else {
        assert_eq!(status, Some(3), "{name}: {errors}{text}");
        assert!(errors.contains("did not answer for"), "{name}: {errors}");
        assert_eq!(summary["completed"], false, "{name}: {text}");
    }
    let axes = summary["axes"].as_array().expect("a list");
    for ((axis, drive), refused) in axes.iter().zip(&end.drives).zip(end.refused) {
        let &DriveEnd {
            counts,
            set_points,
            ignored,
            ..
        } = drive;
        assert_eq!(axis["sent_counts"], counts, "{name}: {text} {end:?}");
        // What was sent twice, or not at all, was counted otherwise by its drive. The link took those that were refused too.
        let handed_over = set_points + ignored + refused;
        assert_eq!(axis["set_points"], handed_over, "{name}: {text} {end:?}");
    }
    end
}

#[test]
fn as_the_manual_says() {
    undisturbed(|| {
        is_used("lawicel", Manner::LAWICEL, Motion::Completes);
    });
}

#[test]
fn without_a_version() {
    undisturbed(|| {
        let manner = Manner {
            version: None,
            ..Manner::LAWICEL
        };
        is_used("no-version", manner, Motion::Completes);
        let manner = Manner {
            ignores_unknown: true,
            ..manner
        };
        let adapter = FakeAdapter::start("ignores-version", manner);
        moves("ignores-version", adapter, Motion::Completes);
    });
}

#[test]
fn with_a_version_that_begins_with_another_letter() {
    undisturbed(|| {
        let manner = Manner {
            version: Some("1a2b3c4 github.com/somebody/slcan-firmware.git"),
            ..Manner::LAWICEL
        };
        is_used("odd-version", manner, Motion::Completes);
    });
}

#[test]
fn without_acknowledgements() {
    undisturbed(|| {
        let manner = Manner {
            acknowledges: false,
            ..Manner::LAWICEL
        };
        is_used("no-ack", manner, Motion::Completes);
        let adapter = FakeAdapter::start("no-ack-note", manner);
        let enable = ["enable", "--drives", "1,2", "--for", "1", "--yes"];
        let (status, _, errors) = command(&adapter, &enable);
        assert_eq!(status, Some(0), "{errors}");
        let note = "acknowledges no frame";
        assert!(errors.contains(note), "the doubt is to be seen: {errors}");
    });
}

#[test]
fn that_starts_for_three_seconds() {
    undisturbed(|| {
        let manner = Manner {
            boots: Duration::from_millis(3_000),
            ..Manner::LAWICEL
        };
        is_used("slow-boot", manner, Motion::Completes);
    });
}

#[test]
fn that_takes_one_command_a_packet() {
    undisturbed(|| {
        let manner = Manner {
            one_command_a_packet: true,
            ..Manner::LAWICEL
        };
        is_used("one-a-packet", manner, Motion::Completes);
    });
}

#[test]
fn that_writes_in_portions() {
    undisturbed(|| {
        let manner = Manner {
            portions: Some(3),
            ..Manner::LAWICEL
        };
        is_used("portions", manner, Motion::Completes);
    });
}

#[test]
fn with_time_stamps_of_four_and_eight_digits() {
    undisturbed(|| {
        for stamp_digits in [4, 8] {
            let manner = Manner {
                stamp_digits,
                ..Manner::LAWICEL
            };
            is_used(&format!("stamps-{stamp_digits}"), manner, Motion::Completes);
        }
    });
}

#[test]
fn that_repeats_its_last_command_on_an_empty_line() {
    undisturbed(|| {
        let manner = Manner {
            version: Some("1a2b3c4 github.com/somebody/slcan-firmware.git"),
            acknowledges: false,
            knows_listen: false,
            repeats: true,
            // A step of 7 counts of drive 2, which is on.
            left_open_after: Some("t05C107"),
            ..Manner::LAWICEL
        };
        is_used("repeats", manner, Motion::Completes);
    });
}

#[test]
fn with_half_a_set_point_of_an_earlier_user() {
    undisturbed(|| {
        for half_a_command in ["t05C10", "t05C", "t05C2010"] {
            let manner = Manner {
                left_open_after: Some("t05C107"),
                half_a_command,
                ..Manner::LAWICEL
            };
            let adapter = FakeAdapter::start(half_a_command, manner);
            moves(half_a_command, adapter, Motion::Completes);
        }
    });
}

#[test]
fn that_loses_answers() {
    undisturbed(|| {
        let motions = [
            (7, Motion::Stops),
            (40, Motion::MayStop),
            (400, Motion::MayStop),
        ];
        for (period, motion) in motions {
            let manner = Manner {
                loses_every: Some(period),
                ..Manner::LAWICEL
            };
            let end = is_used(&format!("loses-{period}"), manner, motion);
            assert!(end.spoilt > 0, "{end:?}");
        }
    });
}

#[test]
fn that_answers_too_often() {
    undisturbed(|| {
        for period in [3, 40] {
            let manner = Manner {
                doubles_every: Some(period),
                ..Manner::LAWICEL
            };
            let end = is_used(&format!("doubles-{period}"), manner, Motion::Completes);
            assert!(end.spoilt > 0, "{end:?}");
        }
    });
}

#[test]
fn with_bells_that_belong_to_nothing() {
    undisturbed(|| {
        let manner = Manner {
            bell_every: Some(60),
            ..Manner::LAWICEL
        };
        let end = is_used("bells", manner, Motion::Completes);
        assert!(end.spoilt > 0, "{end:?}");
    });
}

#[test]
fn that_refuses_a_frame_now_and_then() {
    undisturbed(|| {
        let manner = Manner {
            refuses_every: Some(150),
            ..Manner::LAWICEL
        };
        let adapter = FakeAdapter::start("refuses", manner);
        let end = moves("refuses", adapter, Motion::Completes);
        assert!(end.refused.iter().sum::<u64>() > 0, "{end:?}");
    });
}

#[test]
fn that_cannot_only_listen() {
    undisturbed(|| {
        let manner = Manner {
            knows_listen: false,
            ..Manner::LAWICEL
        };
        is_used("no-listen", manner, Motion::Completes);
        let adapter = FakeAdapter::start("no-listen-decode", manner);
        let (status, _, errors) = command(&adapter, &["decode"]);
        assert_eq!(status, Some(3), "{errors}");
        assert!(errors.contains("--acknowledge"), "{errors}");
    });
}

#[test]
fn a_listener_hears_an_alarm_through_every_kind_that_listens() {
    undisturbed(|| {
        let silent = Manner {
            acknowledges: false,
            ..Manner::LAWICEL
        };
        let no_listen = Manner {
            knows_listen: false,
            ..Manner::LAWICEL
        };
        let active = &["--acknowledge"][..];
        let cases = [
            ("listen", Manner::LAWICEL, &[][..]),
            ("listen-silent", silent, &[]),
            ("listen-active", no_listen, active),
        ];
        for (name, manner, options) in cases {
            let alarm = Some((Stage::Listens, Mishap::Alarm(1)));
            let adapter = FakeAdapter::start_until(name, manner, alarm);
            let link = ["decode", "--slcan", adapter.path(), "--baud", "921600"];
            let mut child = motionctl(&[&link[..], options].concat())
                .spawn()
                .expect("motionctl starts");
            let mut line = String::new();
            let mut lines = BufReader::new(child.stdout.take().expect("it is piped"));
            while !line.contains("over-current") && !line.contains("Drive_Error") {
                line.clear();
                let length = lines.read_line(&mut line).expect("a line");
                assert_ne!(length, 0, "{name}: it ended");
            }
            interrupt(&child);
            assert_eq!(child.wait().expect("its end").code(), Some(0), "{name}");
            let end = adapter.stop();
            assert_eq!((end.repeated, end.early), (0, 0), "{name}: {end:?}");
        }
    });
}
