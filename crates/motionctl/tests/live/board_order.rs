//! `motionctl board stop`, `halt`, `disable` and `clear`.

use serde_json::{Value, json};

use crate::bench::{Scratch, motionctl, scratch, wait_until};
use crate::board_line::{BoardBench, SETTINGS};
use crate::undisturbed::undisturbed;

/// A turn of both motors.
const TURN: &str = "time_s,a,b\n0,0,0\n2,360,-360\n";

/// Gives an order: its exit status, and how the board is.
fn order(bench: &BoardBench, word: &str) -> (Option<i32>, Value) {
    let (status, text, errors) = bench.run(&[word, "--json"]);
    let report: Value = serde_json::from_str(&text).unwrap_or_else(|_| panic!("{errors}"));
    assert_eq!(report["order"], word);
    (status, report)
}

fn is_done(bench: &BoardBench, word: &str, state: &str) {
    let (status, report) = order(bench, word);
    let told = (status, &report["done"], &report["state"]);
    assert_eq!(told, (Some(0), &json!(true), &json!(state)), "{report}");
}

#[test]
fn drives_that_were_left_enabled_are_stopped_halted_and_switched_off_by_a_word() {
    undisturbed(|| {
        let bench = BoardBench::start("board-order", SETTINGS);
        let file = Scratch::new("board-order.csv", TURN);
        let run = ["run", file.path(), "--yes", "--stay-enabled"];
        let (status, text, errors) = bench.run(&run);
        assert_eq!(status, Some(0), "{errors}{text}");
        is_done(&bench, "stop", "enabled");
        is_done(&bench, "clear", "enabled");
        is_done(&bench, "halt", "halted, the drives hold");
        // They have power: nothing is stored, and a stop changes nothing.
        let settings = SETTINGS.replace("speed_rpm = 600", "speed_rpm = 500");
        let settings = Scratch::new("board-order.toml", &settings);
        let (status, _, errors) = bench.run(&["settings", "set", settings.path(), "--yes"]);
        assert_ne!(status, Some(0));
        assert!(errors.contains("refusal 34"), "{errors}");
        is_done(&bench, "stop", "halted, the drives hold");
        // Enabled again by the motion that needs it.
        let (status, text, errors) = bench.run(&run);
        assert_eq!(status, Some(0), "{errors}{text}");
        // Whatever the board has told the program before it meanwhile.
        std::thread::sleep(std::time::Duration::from_secs(1));
        is_done(&bench, "halt", "halted, the drives hold");
        is_done(&bench, "disable", "off");
        is_done(&bench, "disable", "off");
        let (report, steps) = bench.end();
        for drive in report["drives"].as_array().expect("the drives") {
            assert_eq!(drive["enabled"], false, "{report}");
        }
        for steps in &steps {
            // Two turns of 16384 counts.
            assert_eq!(steps.iter().sum::<i64>().abs(), 2 * 16_384);
        }
    });
}

#[test]
fn a_fault_stays_until_a_word_clears_it() {
    undisturbed(|| {
        let adapter = scratch("board-clear-adapter");
        let at = adapter.to_str().expect("plain text");
        let bench = BoardBench::start_with("board-clear", SETTINGS, &["--slcan", at]);
        let turn = Scratch::new("board-clear.csv", TURN);
        let (status, text, errors) = bench.run(&["run", turn.path(), "--yes", "--stay-enabled"]);
        assert_eq!(status, Some(0), "{errors}{text}");
        // A second master switches a drive off.
        let switch = motionctl(&["disable", "--drives", "1", "--slcan", at]).output();
        assert!(switch.expect("it runs").status.success());
        wait_until("the board sees it", || bench.info()["state"] == "faulted");
        let (status, report) = order(&bench, "stop");
        assert_eq!((status, &report["state"]), (Some(0), &json!("faulted")));
        let told = report["axes"][0]["fault"].as_str().unwrap_or_default();
        assert!(told.contains("switched off"), "{report}");
        let (status, _, errors) = bench.run(&["run", turn.path(), "--yes"]);
        assert_eq!(status, Some(1), "{errors}");
        let (status, report) = order(&bench, "clear");
        assert_eq!(
            (status, &report["done"]),
            (Some(0), &json!(true)),
            "{report}"
        );
        is_done(&bench, "disable", "off");
        let (status, text, errors) = bench.run(&["run", turn.path(), "--yes"]);
        assert_eq!(status, Some(0), "{errors}{text}");
    });
}

#[test]
fn a_fault_that_comes_back_is_not_cleared() {
    undisturbed(|| {
        let other = SETTINGS.replacen("gear_number = 4096", "gear_number = 8192", 1);
        let bench = BoardBench::start("board-clear-not", &other);
        let (status, report) = order(&bench, "clear");
        let told = (status, &report["done"], &report["state"]);
        assert_eq!(told, (Some(1), &json!(false), &json!("faulted")));
        let fault = report["axes"][0]["fault"].as_str().unwrap_or_default();
        assert!(fault.contains("gear number"), "{report}");
    });
}

#[test]
fn a_board_without_settings_says_that_it_has_none_to_every_word() {
    undisturbed(|| {
        let bench = BoardBench::start("board-order-none", "");
        for word in ["stop", "halt", "disable", "clear"] {
            let (status, text, errors) = bench.run(&[word]);
            assert_eq!((status, text.as_str()), (Some(1), ""), "{errors}");
            let told = "refusal 28: the board is in another state: expected 'off', got 'no settings'; read its state";
            assert!(errors.contains(told), "{word}: {errors}");
        }
    });
}
