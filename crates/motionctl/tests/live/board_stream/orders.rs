//! What a sender is answered, what it orders, and what is refused before anything moves.

use super::*;

#[test]
fn what_is_no_set_point_is_answered_with_its_number_and_moves_nothing() {
    undisturbed(|| {
        let bench = BoardBench::start("stream-hostile", SETTINGS);
        let (stream, mut sender) = Peer::start(&bench, &["--drives", "2,1"]);
        assert!(sender.ask("0,0,0").starts_with("error 1 104 "));
        assert_eq!(sender.ask("time_s,x_deg,y_deg"), "ready 2 8");
        for (line, expected) in [
            (
                "0,90,0",
                "error 3 202 x_deg: the first set-point must be where the axis stands: expected 0 deg, got 90 deg",
            ),
            ("0,0", "error 4 105 expected 3 fields, one a name, got 2"),
            (
                "0,0,nan",
                "error 5 107 y_deg: expected a finite number, got nan",
            ),
            ("0,0,0x10", "error 6 106 y_deg: expected a number, got 0x10"),
            (
                "0,0,99999",
                "error 7 207 y_deg: beyond its travel: expected -3600 deg to 3600 deg, got 99999 deg",
            ),
            (
                "override 201",
                "error 8 109 an override is a whole percentage: expected 0 to 200, got 201",
            ),
        ] {
            assert_eq!(sender.ask(line), expected);
        }
        assert!(sender.ask(&"7".repeat(5_000)).starts_with("error 9 101 "));
        sender.say("0,0,0");
        assert_eq!(
            sender.ask("0,0,0"),
            "error 11 204 the time is out of order: expected later than 0 s, got 0 s"
        );
        sender.say("0.02,0,0");
        assert!(sender.ask("0.01,0,0").starts_with("error 13 204 "));
        assert!(sender.ask("0.0201,0,0").starts_with("error 14 205 "));
        assert!(sender.ask("20,0,0").starts_with("error 15 206 "));
        assert!(
            sender
                .ask("0.04,360,0")
                .starts_with("error 16 208 x_deg: too fast: expected at most 30")
        );
        // It is slow enough and begins too hard: known with the next one.
        let answer = sender.ask("0.04,25,0");
        let expected = "error 17 209 x_deg: too much acceleration: expected at most 20000";
        assert!(answer.starts_with(expected), "{answer}");
        let status = sender.ask("status");
        assert!(
            status.starts_with("status 18 phase=Waiting speed=0"),
            "{status}"
        );
        assert_eq!(sender.ask("stop"), "end stopped by an order");
        let (summary, _) = stream.ends_with(130);
        assert_eq!(counted(&summary), [Some(2), Some(8), Some(6)], "{summary}");
        assert_eq!(numbers(&summary["axes"], "drive"), [2, 1]);
        let steps = agree(&summary, bench);
        assert!(
            steps.iter().flatten().all(|step| *step == 0),
            "nothing has moved"
        );
    });
}

#[test]
fn a_refused_line_in_motion_is_left_out_and_the_others_are_on_the_bus() {
    undisturbed(|| {
        let bench = BoardBench::start("stream-refused", SETTINGS);
        let mut stream = Streamed::start(&bench, &[]);
        stream.say(NAMES);
        let counts = eased(100, 8_192);
        let mut written = Vec::new();
        for (place, x) in counts.iter().enumerate() {
            if place == 40 {
                // Three turns away, then a letter.
                stream.say(&line(20 * place, x + 49_152));
                stream.say(&format!("{},{x}a,0", 20 * place));
                continue;
            }
            stream.say(&line(20 * place, *x));
            written.push((20 * place, *x));
        }
        stream.say("end");
        let (summary, errors) = stream.ends_with(0);
        assert!(
            errors.contains("error 42 208 x_counts: too fast"),
            "{errors}"
        );
        assert!(
            errors.contains("error 43 106 x_counts: expected a number"),
            "{errors}"
        );
        assert_eq!(counted(&summary), [Some(100), Some(1), Some(1)]);
        let steps = agree(&summary, bench);
        has_every(&steps[0], &written);
    });
}

#[test]
fn an_override_goes_no_further_than_the_limits_of_the_user() {
    undisturbed(|| {
        let bench = BoardBench::start("stream-override", SETTINGS);
        let ahead = ["--ahead-ms", "20000", "--max-turns", "40"];
        let (stream, mut sender) = Peer::start(&bench, &ahead);
        assert_eq!(sender.ask(NAMES), "ready 2 8");
        for (place, x) in constant(300).into_iter().enumerate() {
            sender.say(&line(20 * place, x));
        }
        sender.say("override 200");
        wait_until("it is held", || {
            sender.ask("status").contains("speed=100 asked=100")
        });
        assert_eq!(sender.ask("stop"), "end stopped by an order");
        let (summary, errors) = stream.ends_with(130);
        assert!(errors.contains("held to 100 %"), "{errors}");
        // It was stopped, and some were played.
        let sent = summary["segments_sent"].as_u64();
        assert!(sent > Some(2), "{summary}");
        agree(&summary, bench);
    });
}

#[test]
fn orders_of_the_sender_pause_and_stop_on_the_path() {
    undisturbed(|| {
        let bench = BoardBench::start("stream-orders", SETTINGS);
        let (stream, mut sender) =
            Peer::start(&bench, &["--ahead-ms", "20000", "--max-turns", "40"]);
        sender.say("pause");
        assert_eq!(sender.ask(NAMES), "ready 2 8");
        for (place, x) in constant(600).into_iter().enumerate() {
            sender.say(&line(20 * place, x));
        }
        let until = |sender: &mut Peer, what: &str| {
            wait_until(what, || sender.ask("status").contains(what));
        };
        until(&mut sender, "phase=Waiting speed=0 asked=100 paused=true");
        sender.say("override 50");
        sender.say("resume");
        until(&mut sender, "speed=50 asked=50 paused=false");
        sender.say("pause");
        until(&mut sender, "speed=0 asked=50 paused=true");
        assert_eq!(sender.ask("stop"), "end stopped by an order");
        let (summary, _) = stream.ends_with(130);
        let sent = numbers(&summary["axes"], "set_point_counts");
        assert!(
            sent[0] > 0 && (sent[0] + 2 * sent[1]).abs() <= 2,
            "{sent:?}"
        );
        agree(&summary, bench);
    });
}

#[test]
fn the_client_of_the_documents_and_the_recording_with_its_names() {
    undisturbed(|| {
        let folder = Folder::new("board-stream-page");
        std::fs::create_dir_all(&folder.0).expect("a folder");
        let [page, table] = ["page", "run.csv"].map(|name| folder.file(name));
        let bench = BoardBench::start("stream-client", SETTINGS);
        let mut stream = Streamed::start(&bench, &["tcp:0", "--report", &page, "--csv", &table]);
        let port = port_of(&mut stream);
        let root = Path::new(env!("CARGO_MANIFEST_DIR")).join("../..");
        let client = Command::new("python3")
            .arg(root.join("examples/stream.py"))
            .args([&port.to_string(), "--seconds", "6"])
            .output()
            .expect("Python is there");
        let said = String::from_utf8_lossy(&client.stdout).into_owned();
        assert!(said.ends_with("end completed\n"), "{client:?}");
        let (summary, _) = stream.ends_with(0);
        assert_eq!(counted(&summary), [Some(301), Some(0), Some(0)]);
        assert_eq!(
            numbers(&summary["axes"], "set_point_counts"),
            [4_096, 4_096]
        );
        assert_eq!(Page::in_folder(&page).axes(), ["x_deg", "y_deg"]);
        let rows = std::fs::read_to_string(&table).expect("a table");
        assert!(rows.contains(",4096,"), "{rows}");
        agree(&summary, bench);
    });
}

#[test]
fn what_cannot_be_used_is_refused_before_anything_is_enabled() {
    let bench = BoardBench::start("stream-options", SETTINGS);
    let file = Scratch::new("stream-options.csv", "time_s,a,b\n0,0,0\n");
    for (options, expected) in [
        (
            &["--trajectory", file.path()][..],
            "`motionctl board run` plays files",
        ),
        (
            &["--candump", "/tmp/none.log"],
            "the frames are on the bus of the board",
        ),
        (&["--drives", "1,7"], "the board has no drive 7"),
        (
            &["--counts-per-turn", "8192"],
            "give --counts-per-turn 16384",
        ),
        (
            &["--counts-per-turn", "8192,8192,8192"],
            "or 2 for 2 axes, got 3",
        ),
        (&["--lead-ms", "100"], "100 is not in 300..=10000"),
        (&["udp:7"], "expected -, tcp:PORT"),
        (&["tcp:0.0.0.0:7001"], "or --allow-remote"),
    ] {
        let (status, _, errors) = bench.run(&[&["stream", "--yes"], options].concat());
        assert_eq!(status, Some(2), "{options:?}: {errors}");
        assert!(errors.contains(expected), "{options:?}: {errors}");
    }
    let (_, steps) = bench.end();
    assert_eq!(json!(steps), json!([[], []]));
}
