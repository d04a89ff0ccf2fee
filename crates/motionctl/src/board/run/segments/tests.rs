//! Every set-point that the player of the board gives is that of the table of the motion, whatever the file.

use clap::Parser as _;
use dyn_can::StepLimit;
use proptest::prelude::*;
use trajectory::Limits;

use super::*;
use crate::trajectory::MotionOptions;

#[derive(clap::Parser)]
struct Cli {
    #[command(flatten)]
    motion: MotionOptions,
}

/// Limits that leave room for everything a drive can follow.
fn wide() -> AxisLimits {
    AxisLimits {
        motion: Limits::without_jerk(16_000.0, 10_000.0).unwrap(),
        lowest: Position::from_counts(i32::MIN / 2),
        highest: Position::from_counts(i32::MAX / 2),
    }
}

/// Plays a file on two of three axes of a board that stand somewhere.
fn play(text: &str, options: &[&str], cycle_us: u32) -> (Played, Plan) {
    let folder = tempfile::tempdir().unwrap();
    let file = folder.path().join("motion.csv");
    std::fs::write(&file, text).unwrap();
    let file = file.to_str().unwrap();
    play_words(&[&["--trajectory", file][..], options].concat(), cycle_us)
}

fn play_words(options: &[&str], cycle_us: u32) -> (Played, Plan) {
    let motion = Cli::parse_from([&["test"], options].concat()).motion;
    let plan = motion.read().unwrap().plan(cycle_us, StepLimit::MAX);
    let plan = plan.unwrap_or_else(|error| panic!("{error}\n{options:?}"));
    let segments = segments(&plan).unwrap();
    let (places, from) = ([2, 0], [1_000, -77, -123_456]);
    let played = preview(
        &segments,
        &[wide(); 3],
        (&places, &from),
        cycle_us,
        |cycle| plan.row(cycle),
    );
    (
        played.unwrap_or_else(|error| panic!("{error:?}\n{options:?}")),
        plan,
    )
}

fn check(text: &str, options: &[&str], cycle_us: u32) {
    let (played, plan) = play(text, options, cycle_us);
    let expected = Played {
        cycles: plan.cycles() as u64,
        worst_counts: 0,
    };
    assert_eq!(played, expected, "{options:?} {cycle_us} us\n{text}");
}

const TURN: &str = "time_s,a,b\n0,0,0\n0.25,180,-90\n0.6,360,-180\n1.0,300,-180\n";

#[test]
fn set_points_of_every_format_are_those_of_the_table() {
    for interpolation in ["monotone", "linear"] {
        let with = ["--interpolation", interpolation];
        check(TURN, &with, 1_000);
        // Points between cycles, before and behind them; another cycle.
        check(
            "t a b\n5 0 0\n5.10033 20 -3\n5.3007 90 1\n5.9 90 1\n",
            &with,
            1_000,
        );
        check(TURN, &with, 1_500);
        // A way that is longer than a segment of the board may be, with a rest.
        check(
            "time_ms;a;b\n0;0;0\n40000;720;-3\n41000;720;-3\n",
            &with,
            1_000,
        );
        check(
            "time_s,x_mm,y_mm\n0,0,0\n0.5,10,-7\n1,0,0\n",
            &[&with[..], &["--mm-per-turn", "4"]].concat(),
            1_000,
        );
        check("time_s,a_rad,b_rad\n0,0,0\n0.5,1,-2\n1,0,0\n", &with, 1_000);
    }
}

#[test]
fn points_closer_than_cycles_are_the_same_set_points() {
    let point = |ms: f64| format!("{ms},{},{}\n", 90.0 * (ms / 250.0).sin(), -ms);
    let mut text = String::from("time_ms,a,b\n");
    text.extend((0..4_000).map(|place| point(f64::from(place) * 0.25)));
    check(&text, &[], 1_000);
}

#[test]
fn a_program_is_played_within_a_count() {
    let program = concat!(
        env!("CARGO_MANIFEST_DIR"),
        "/../../examples/programs/slot.ngc"
    );
    let words = ["--program", program, "--axes", "2", "--mm-per-turn", "5"];
    let check = move || {
        let (played, plan) = play_words(&words, 1_000);
        assert_eq!(played.cycles, plan.cycles() as u64);
        assert!(played.worst_counts <= 1, "{played:?}");
    };
    // What plays a program takes the stack of a main thread.
    let thread = std::thread::Builder::new().stack_size(8 << 20);
    thread.spawn(check).unwrap().join().unwrap();
}

#[test]
fn what_the_board_would_refuse_is_named_with_its_segment_and_time() {
    let (_, plan) = play(TURN, &[], 1_000);
    let segments = segments(&plan).unwrap();
    let narrow = AxisLimits {
        highest: Position::from_counts(10_000),
        ..wide()
    };
    // The first column is the second axis here, which may not go so far as the second segment takes it.
    let limits = [wide(), narrow];
    let refusal = preview(&segments, &limits, (&[1, 0], &[0, 0]), 1_000, |cycle| {
        plan.row(cycle)
    });
    let refusal = refusal.unwrap_err();
    assert_eq!(refusal.refused.reason(), Some(board_link::Reason::Travel));
    assert_eq!(
        (refusal.refused.axis, refusal.segment, refusal.at_cycles),
        (Some(1), 1, 250.0)
    );
    // The same from elsewhere stays within it.
    let elsewhere = (&[1, 0][..], &[0, -10_000][..]);
    let played = preview(&segments, &limits, elsewhere, 1_000, |cycle| {
        plan.row(cycle)
    });
    assert_eq!(played.map(|played| played.worst_counts), Ok(0));
}

proptest! {
    #![proptest_config(ProptestConfig { cases: 48, ..ProptestConfig::default() })]

    /// Any points at any times that a drive can follow.
    #[test]
    fn set_points_of_random_tables_are_those_of_the_table(
        points in prop::collection::vec((0.02_f64..0.7, -90.0_f64..90.0, -90.0_f64..90.0), 2..12),
        linear in any::<bool>(),
        whole in any::<bool>(),
        cycle_us in prop_oneof![Just(1_000_u32), Just(500), Just(1_250), Just(4_000)],
    ) {
        let mut text = String::from("t,a,b\n0,0,0\n");
        let mut time = 0.0;
        for (step, a, b) in points {
            time += if whole { (step * 1_000.0).round() / 1_000.0 } else { step };
            text.push_str(&format!("{time:.6},{a:.4},{b:.4}\n"));
        }
        let interpolation = if linear { "linear" } else { "monotone" };
        check(&text, &["--interpolation", interpolation], cycle_us);
    }
}
