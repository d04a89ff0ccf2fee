use clap::Parser as _;
use proptest::prelude::*;

use super::*;

#[derive(clap::Parser)]
struct Cli {
    #[command(flatten)]
    motion: MotionOptions,
}

fn options(words: &[&str]) -> MotionOptions {
    Cli::parse_from([&["test"], words].concat()).motion
}

fn text(line: &str) -> Line {
    Line::Text(line.to_owned())
}

/// The last of some lines.
fn last(words: &[&str], axes: usize, lines: &[&str]) -> Result<Parsed, LineError> {
    let options = options(words);
    let mut parser = Parser::new(&options, axes);
    let parsed = (1..)
        .zip(lines)
        .map(|(number, line)| parser.line(number, &text(line)));
    parsed.last().expect("a line")
}

fn set_point(parsed: Result<Parsed, LineError>) -> (f64, Vec<f64>) {
    match parsed {
        Ok(Parsed::SetPoint(set_point, _)) => (set_point.time_s, set_point.counts),
        other => panic!("{other:?}"),
    }
}

#[test]
fn names_and_units_are_those_of_files() {
    let lines = ["time_ms,x_deg,v_rpm,y_turns", "250,90,5,-0.5"];
    let (time_s, counts) = set_point(last(&[], 2, &lines));
    assert_eq!((time_s, counts), (0.25, vec![4_096.0, -8_192.0]));
    let lines = ["t;x_mm", "0,5;2,5"];
    let words = ["--decimal-comma", "--mm-per-turn", "5"];
    assert_eq!(set_point(last(&words, 1, &lines)), (0.5, vec![8_192.0]));
    let lines = [
        r#"{"y_deg": 1, "t": 2, "x_deg": 90}"#,
        r#"{"x_deg":180,"y_deg":90,"t":3}"#,
    ];
    // The order of the first line is that of the axes.
    assert_eq!(
        set_point(last(&[], 2, &lines)),
        (3.0, vec![4_096.0, 8_192.0])
    );
}

#[test]
fn what_is_no_set_point_has_a_number() {
    let named = "time_s,x_deg,y_deg";
    for (lines, number, expected) in [
        (vec!["0,0,0"], 104, "expected names, got numbers"),
        (vec!["time_s,x_deg"], 104, "expected time and 2 axes"),
        (vec!["time_s,x_deg,y_kg"], 104, "kg"),
        (
            vec![named, "0,0"],
            105,
            "expected 3 fields, one a name, got 2",
        ),
        (vec![named, "0,0,0,0"], 105, "got 4"),
        (vec![named, "0,,0"], 106, "x_deg: expected a number"),
        (
            vec![named, "0,0,1.2.3"],
            106,
            "y_deg: expected a number, got 1.2.3",
        ),
        (
            vec![named, "0,nan,0"],
            107,
            "x_deg: expected a finite number, got nan",
        ),
        (
            vec![named, "0,0,1e308"],
            107,
            "y_deg: expected a finite number",
        ),
        (vec![named, "inf,0,0"], 107, "time_s"),
        (
            vec![named, "faster"],
            108,
            "expected pause, resume, override PERCENT, stop or status",
        ),
        (
            vec![named, "override 500"],
            109,
            "expected 0 to 200, got 500",
        ),
        (vec![named, "{\"t\":"], 110, "EOF"),
        (vec!["{\"t\":0,\"t\":1}"], 110, "twice"),
        (vec!["{\"t\":0,\"x\":[1]}"], 110, "did not match"),
        (
            vec!["{\"t\":0,\"x\":\"1\"}"],
            106,
            "expected a number, got the text",
        ),
    ] {
        let error = last(&[], 2, &lines).unwrap_err();
        assert_eq!(error.number, number, "{lines:?}: {error:?}");
        assert!(error.text.contains(expected), "{lines:?}: {error:?}");
    }
    let options = options(&[]);
    let mut parser = Parser::new(&options, 1);
    let number = |line| Parser::line(&mut parser, 1, &line).unwrap_err().number;
    let lines = [
        Line::TooLong { actual: 5_000 },
        Line::NotText { at: 0 },
        Line::Unfinished { actual: 3 },
    ];
    assert_eq!(lines.map(number), [101, 102, 103]);
}

#[test]
fn orders_are_words_between_set_points() {
    let after = |line| last(&[], 1, &["t,x_deg", line]);
    assert_eq!(after("pause"), Ok(Parsed::Order(Order::Pause)));
    assert_eq!(after("override 50"), Ok(Parsed::Order(Order::Override(50))));
    assert_eq!(after("end"), Ok(Parsed::End));
    assert_eq!(after("status"), Ok(Parsed::Status));
    assert_eq!(after("# a comment"), Ok(Parsed::Nothing));
    assert_eq!(after(""), Ok(Parsed::Nothing));
    let json = r#"{"order": "override", "percent": 50}"#;
    assert_eq!(after(json), Ok(Parsed::Order(Order::Override(50))));
    assert_eq!(after(r#"{"order":"end"}"#), Ok(Parsed::End));
}

proptest! {
    #![proptest_config(ProptestConfig { cases: 2_000, ..ProptestConfig::default() })]

    /// Whatever the bytes: no panic, and a set-point only of as many finite numbers as there are axes.
    #[test]
    fn any_line_is_a_set_point_or_an_error(
        lines in proptest::collection::vec(
            prop_oneof![
                "[ -~]{0,40}",
                "\\PC{0,30}",
                "-?[0-9]{0,3}(\\.[0-9]{0,4})?,-?[0-9.e]{0,6},-?[0-9]{1,9}",
                "\\{\"(t|x|order)\":\"?[0-9a-z.]{0,6}\"?(,\"(x|percent|y)\":-?[0-9.e]{0,5})?\\}?",
                Just("time_s,x_deg,y_deg".to_owned()),
            ],
            1..12,
        ),
    ) {
        let options = options(&[]);
        let mut parser = Parser::new(&options, 2);
        for (number, line) in (1..).zip(&lines) {
            if let Ok(Parsed::SetPoint(set_point, _)) = parser.line(number, &text(line)) {
                prop_assert!(set_point.time_s.is_finite());
                prop_assert_eq!(set_point.counts.len(), 2);
                prop_assert!(set_point.counts.iter().all(|counts| counts.is_finite()));
            }
        }
    }
}
