//! However a stream ends, the axes come to rest within their limits, and the drives are off.

use super::*;

#[test]
fn a_writer_that_falls_silent_is_a_ramp_a_message_and_a_clean_end() {
    undisturbed(|| {
        let bench = BoardBench::start("stream-silent", SETTINGS);
        let mut stream = Streamed::start(&bench, &[]);
        stream.say(NAMES);
        let counts = constant(100);
        stream.points(0, 20, &counts);
        // Nothing more comes, and the input stays open.
        let mut input = stream.child.stdin.take();
        let (summary, errors, status) = stream.end();
        drop(input.take());
        assert_eq!(status, Some(1), "{summary} {errors}");
        assert_eq!(summary["outcome"], "the set-points ran out", "{summary}");
        assert_eq!(summary["stream"]["ran_dry"], 1, "{summary}");
        for told in [
            "the set-points are late",
            "the set-points ran out: the axes have come to rest along the path",
        ] {
            assert!(errors.contains(told), "{told}: {errors}");
        }
        let steps = agree(&summary, bench);
        let sent = numbers(&summary["axes"], "set_point_counts");
        // On the path, and before what was not sent.
        assert!((sent[0] + 2 * sent[1]).abs() <= 2, "{sent:?}");
        assert!(
            sent[0] > 2_000 && Some(&sent[0]) < counts.last(),
            "{sent:?}"
        );
        assert_eq!(sums(&steps[0]).last(), Some(&sent[0]));
    });
}

#[test]
fn a_writer_that_comes_back_goes_on_where_the_board_waits() {
    undisturbed(|| {
        let bench = BoardBench::start("stream-wait", SETTINGS);
        let mut stream = Streamed::start(&bench, &["--when-dry", "wait"]);
        stream.say(NAMES);
        let counts = eased(200, 16_384);
        stream.points(0, 20, &counts[..100]);
        // Enabled within a second, two seconds of path, and a second for nothing.
        std::thread::sleep(Duration::from_millis(4_500));
        stream.points(100, 20, &counts[100..]);
        stream.say("end");
        let (summary, _) = stream.ends_with(0);
        assert_eq!(summary["stream"]["ran_dry"], 1, "{summary}");
        assert_eq!(counted(&summary), [Some(201), Some(0), Some(0)]);
        assert_eq!(
            numbers(&summary["axes"], "set_point_counts"),
            [16_384, -8_192]
        );
        agree(&summary, bench);
    });
}

#[test]
fn a_writer_that_dies_in_motion_leaves_axes_at_rest_at_its_last_whole_line() {
    undisturbed(|| {
        let bench = BoardBench::start("stream-dies", SETTINGS);
        let mut stream = Streamed::start(&bench, &[]);
        stream.say(NAMES);
        let counts = eased(100, 4_096);
        stream.points(0, 20, &counts[..60]);
        // Cut off: the whole number would be 1200.
        let input = stream.child.stdin.as_mut().expect("it is open");
        input.write_all(b"12").expect("it reads");
        let (summary, errors) = stream.ends_with(1);
        assert_eq!(summary["outcome"], "the set-points ran out", "{summary}");
        assert!(
            errors.contains("the sender has gone without an end"),
            "{errors}"
        );
        assert_eq!(counted(&summary), [Some(60), Some(0), Some(1)]);
        let last = counts[59];
        assert_eq!(
            numbers(&summary["axes"], "target_counts"),
            [last, -last / 2]
        );
        assert_eq!(
            numbers(&summary["axes"], "set_point_counts"),
            [last, -last / 2]
        );
        agree(&summary, bench);
    });
}

#[test]
fn an_end_that_is_too_fast_to_stop_at_stops_before_it() {
    undisturbed(|| {
        let bench = BoardBench::start("stream-abrupt", SETTINGS);
        let mut stream =
            Streamed::start(&bench, &["--max-acceleration", "1500", "--max-rpm", "600"]);
        stream.say(NAMES);
        // 50 counts a cycle, at 0.05 counts a cycle and cycle.
        let counts: Vec<i64> = (0..=70_i64).map(|step| step * step * 10).collect();
        stream.points(0, 20, &counts);
        stream.say("end");
        let (summary, errors) = stream.ends_with(1);
        assert!(
            errors.contains("too fast to come to rest there"),
            "{errors}"
        );
        assert_eq!(summary["completed"], false);
        let sent = numbers(&summary["axes"], "set_point_counts");
        let last = counts.last().copied().unwrap_or(0);
        assert!(sent[0] > last / 2 && sent[0] < last, "{sent:?} of {last}");
        agree(&summary, bench);
    });
}

#[test]
fn ctrl_c_stops_on_the_path_and_disables() {
    undisturbed(|| {
        let bench = BoardBench::start("stream-interrupt", SETTINGS);
        let mut stream = Streamed::start(&bench, &["--max-turns", "40"]);
        stream.say(NAMES);
        let counts = constant(400);
        // More than may be ahead waits in the pipe.
        stream.points(0, 20, &counts);
        std::thread::sleep(Duration::from_secs(4));
        interrupt(&stream.child);
        let (summary, _) = stream.ends_with(130);
        assert_eq!(summary["outcome"], "stopped by the user");
        let sent = numbers(&summary["axes"], "set_point_counts");
        assert!(
            sent[0] > 2_000 && (sent[0] + 2 * sent[1]).abs() <= 2,
            "{sent:?}"
        );
        agree(&summary, bench);
    });
}

#[test]
fn ctrl_c_before_anything_was_written_disables() {
    undisturbed(|| {
        let bench = BoardBench::start("stream-nothing", SETTINGS);
        let stream = Streamed::start(&bench, &[]);
        std::thread::sleep(Duration::from_secs(2));
        interrupt(&stream.child);
        let (summary, _) = stream.ends_with(130);
        agree(&summary, bench);
    });
}

#[test]
fn more_set_points_than_the_memory_of_the_board_holds_are_refused_before_anything_moves() {
    undisturbed(|| {
        let bench = BoardBench::start("stream-dense", SETTINGS);
        let mut stream = Streamed::start(&bench, &[]);
        stream.say("t_ms,x_turns,y_turns");
        for ms in (0..320_u32).step_by(4) {
            let turns = f64::from(ms).powi(3) * 1e-9;
            stream.say(&format!("{ms},{turns},0"));
        }
        stream.say("end");
        let (summary, errors) = stream.ends_with(1);
        let why = "expected 56 of them in at least 300 ms, which are 186 a second";
        assert!(errors.contains(why), "{errors}");
        let outcome = "stopped, because the set-points cannot be played";
        assert_eq!(summary["outcome"], outcome, "{summary}");
        let text =
            "205 the time is too close to the set-points before: expected at least 300 ms, got";
        assert!(errors.contains(text), "{errors}");
        assert_eq!(summary["stream"]["refused_by_number"][0][0], 205);
        let steps = agree(&summary, bench);
        assert!(steps.iter().flatten().all(|step| *step == 0));
    });
}

#[test]
fn a_sender_that_becomes_too_fast_in_motion_is_stopped_on_the_path() {
    undisturbed(|| {
        let bench = BoardBench::start("stream-faster", SETTINGS);
        let mut stream = Streamed::start(&bench, &["--max-turns", "20"]);
        stream.say("t_ms,x_turns,y_turns");
        let (mut ms, mut turns) = (0, 0.0);
        for step in 0..400_u32 {
            stream.say(&format!("{ms},{turns:.6},{:.6}", -0.5 * turns));
            let gap = if step < 100 { 20 } else { 2 };
            // Up to 2 turns a second.
            turns += 1e-3 * f64::from(gap) * (0.02 * f64::from(step)).min(2.0);
            ms += gap;
        }
        stream.say("end");
        let (summary, errors) = stream.ends_with(1);
        assert!(
            errors.contains("more set-points than the memory"),
            "{errors}"
        );
        let sent = numbers(&summary["axes"], "set_point_counts");
        assert!(
            sent[0] > 2_000 && (sent[0] + 2 * sent[1]).abs() <= 2,
            "{sent:?}"
        );
        agree(&summary, bench);
    });
}

#[test]
fn a_path_that_ends_too_fast_before_it_begins_is_not_played() {
    undisturbed(|| {
        let ends = [&["end"][..], &[]];
        for (place, end) in ends.into_iter().enumerate() {
            let bench = BoardBench::start(&format!("stream-short-{place}"), SETTINGS);
            let mut stream = Streamed::start(&bench, &[]);
            stream.say(NAMES);
            // In 30 ms from rest to rest: far more acceleration than there may be.
            for line in ["0,0,0", "10,500,0"] {
                stream.say(line);
            }
            end.iter().for_each(|end| stream.say(end));
            let (summary, errors) = stream.ends_with(1);
            assert!(errors.contains("nothing was moved"), "{errors}");
            assert!(errors.contains("expected at most"), "{errors}");
            assert_eq!(numbers(&summary["axes"], "set_point_counts"), [0, 0]);
            agree(&summary, bench);
        }
    });
}

#[test]
fn a_last_way_that_takes_longer_than_its_time_is_told() {
    undisturbed(|| {
        let bench = BoardBench::start("stream-slow-end", SETTINGS);
        let mut stream = Streamed::start(&bench, &[]);
        stream.say(NAMES);
        stream.points(0, 20, &eased(100, 20_000)[..81]);
        stream.say("end");
        let (summary, errors) = stream.ends_with(0);
        assert!(errors.contains(" s instead of 0.020 s"), "{errors}");
        agree(&summary, bench);
    });
}
