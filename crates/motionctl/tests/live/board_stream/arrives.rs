//! Set-points that come in time arrive: every one, in its cycle.

use super::*;

/// Pauses of 0 to `most` milliseconds, the same at each call with a seed.
fn pauses(seed: u64, most: u64) -> impl Iterator<Item = Duration> {
    let mut state = seed;
    core::iter::repeat_with(move || {
        // Knuth's MMIX.
        state = state.wrapping_mul(6_364_136_223_846_793_005);
        state = state.wrapping_add(1_442_695_040_888_963_407);
        Duration::from_millis((state >> 33) % (most + 1))
    })
}

#[test]
fn every_set_point_that_is_written_is_on_the_bus_at_its_cycle() {
    undisturbed(|| {
        let bench = BoardBench::start("stream-every", SETTINGS);
        let mut stream = Streamed::start(&bench, &[]);
        stream.say(NAMES);
        let counts = eased(150, 16_384);
        stream.points(0, 20, &counts);
        stream.say("end");
        let (summary, _) = stream.ends_with(0);
        assert_eq!(
            (&summary["completed"], &summary["outcome"]),
            (&true.into(), &"completed".into())
        );
        assert_eq!(counted(&summary), [Some(151), Some(0), Some(0)]);
        assert_eq!(summary["segments_sent"], 150);
        assert_eq!(numbers(&summary["axes"], "target_counts"), [16_384, -8_192]);
        let steps = agree(&summary, bench);
        let x: Vec<(usize, i64)> = (0..).step_by(20).zip(counts.iter().copied()).collect();
        let y: Vec<(usize, i64)> = x.iter().map(|(at, x)| (*at, -x / 2)).collect();
        has_every(&steps[0], &x);
        has_every(&steps[1], &y);
    });
}

#[test]
fn a_writer_whose_lines_come_up_to_270_ms_late_costs_nothing() {
    undisturbed(|| {
        let seed = u64::from(std::process::id());
        println!("seed {seed}");
        let bench = BoardBench::start("stream-jitter", SETTINGS);
        let mut stream = Streamed::start(&bench, &[]);
        stream.say(NAMES);
        let counts = eased(200, 16_384);
        // In real time: what is buffered at the start is what may be late, less 130 ms for slowing down.
        // Before it is enabled nothing is late.
        std::thread::sleep(Duration::from_secs(2));
        let start = Instant::now();
        for ((place, x), late) in counts.iter().enumerate().zip(pauses(seed, 20)) {
            let once = Duration::from_millis(if place == 100 { 270 } else { 0 });
            let due = Duration::from_millis(20 * place as u64) + late.max(once);
            std::thread::sleep(due.saturating_sub(start.elapsed()));
            stream.say(&line(20 * place, *x));
        }
        stream.say("end");
        let (summary, errors) = stream.ends_with(0);
        assert_eq!(counted(&summary), [Some(201), Some(0), Some(0)]);
        assert_eq!(summary["stream"]["ran_dry"], 0, "{summary}");
        assert!(!errors.contains("late"), "{errors}");
        let steps = agree(&summary, bench);
        let x: Vec<(usize, i64)> = (0..).step_by(20).zip(counts).collect();
        has_every(&steps[0], &x);
    });
}

#[test]
fn a_second_stream_begins_where_the_first_one_ended() {
    undisturbed(|| {
        let bench = BoardBench::start("stream-second", SETTINGS);
        let counts = eased(50, 2_048);
        let stream_once = || {
            let mut stream = Streamed::start(&bench, &["--snapshot-hz", "1000"]);
            stream.say(NAMES);
            // Long after the drives are enabled: until then the board tells of the stream before.
            std::thread::sleep(Duration::from_secs(2));
            stream.points(7, 20, &counts);
            stream.say("end");
            let (summary, _) = stream.ends_with(0);
            assert_eq!(counted(&summary), [Some(51), Some(0), Some(0)]);
            for sums in ["target_counts", "set_point_counts"] {
                assert_eq!(numbers(&summary["axes"], sums), [2_048, -1_024]);
            }
        };
        stream_once();
        stream_once();
        let (report, steps) = bench.end();
        assert_eq!(
            numbers(&report["drives"], "received_counts"),
            [4_096, -2_048]
        );
        is_within_limits(&steps);
    });
}

/// A lead that is as long as a sender may be ahead.
#[test]
fn a_lead_as_long_as_what_may_be_ahead_is_reached() {
    undisturbed(|| {
        for (lead, when_dry) in [("1000", "end"), ("300", "wait")] {
            let bench = BoardBench::start("stream-lead", SETTINGS);
            let lead = ["--lead-ms", lead, "--ahead-ms", lead];
            let all = [&lead[..], &["--when-dry", when_dry]].concat();
            let mut stream = Streamed::start(&bench, &all);
            stream.say(NAMES);
            let counts = eased(100, 4_096);
            stream.points(0, 20, &counts);
            stream.say("end");
            let (summary, _) = stream.ends_with(0);
            assert_eq!(counted(&summary), [Some(101), Some(0), Some(0)]);
            agree(&summary, bench);
        }
    });
}
