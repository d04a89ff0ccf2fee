//! `motionctl sim --drives zlac`, recorded and watched: speeds in every file, and on the screen.

mod tool;

use tool::page::Page;
use tool::screen::OnScreen;
use tool::{Folder, motionctl, text};

/// A trip after a second, and its cause gone later.
const FAULT: &str = "[[trip]]\nat_s = 1.0\nnode = 5\nfault = \"over-current\"\n";

/// The values of a column of a table.
fn column(table: &str, name: &str) -> Vec<f64> {
    let mut lines = table.lines();
    let names = lines.next().expect("a line of names");
    let place = names.split(',').position(|other| other == name);
    let place = place.unwrap_or_else(|| panic!("{name} in {names}"));
    let value = |line: &str| line.split(',').nth(place).expect("a cell").parse();
    lines.map(|line| value(line).expect("a number")).collect()
}

#[test]
fn the_page_the_table_and_the_file_of_wheels_have_the_same_speeds() {
    let folder = Folder::new("wheels");
    std::fs::create_dir_all(&folder.0).expect("a folder");
    let script = folder.file("faults.toml");
    std::fs::write(&script, FAULT).expect("a script");
    let [csv, mcap] = ["run.csv", "run.mcap"].map(|name| folder.file(name));
    let files = ["--csv", &csv, "--mcap", &mcap, "--report", folder.as_str()];
    let words = ["sim", "--drives", "zlac", "--json", "--faults", &script];
    let output = motionctl(&[&words[..], &files].concat());
    assert_eq!(output.status.code(), Some(1), "a wheel trips: {output:?}");
    let page = Page::in_folder(folder.as_str());
    assert_eq!(page.data()["quantity"], "speed");
    assert_eq!(page.axes(), ["left_rpm", "right_rpm"]);
    let table = std::fs::read_to_string(&csv).expect("the table");
    let messages = speeds_of(&mcap);
    for (axis, node) in [4, 5].into_iter().enumerate() {
        let milli = |name: &str| -> Vec<i64> {
            let values = column(&table, &format!("node{node}_{name}"));
            values
                .iter()
                .map(|rpm| (rpm * 1e3).round() as i64)
                .collect()
        };
        assert_eq!(page.target(axis), milli("target_rpm"));
        assert_eq!(page.sent(axis), milli("sent_rpm"));
        let shown: Vec<i64> = page.positions(axis).iter().map(|(_, rpm)| *rpm).collect();
        assert_eq!(shown, milli("speed_rpm"));
        assert_eq!(messages[axis], shown);
        assert!(shown.iter().any(|speed| *speed > 10_000), "{shown:?}");
    }
    let events = page.data()["events"].to_string();
    assert!(events.contains("node 5 trips"), "{events}");
    let texts = page.data()["texts"].to_string();
    assert!(texts.contains("\"p|"), "set-points are coloured as such");
    let count = page.data()["deviationsUs"].as_array().map(Vec::len);
    assert!(
        count.is_some_and(|count| count > 0),
        "intervals of set-points"
    );
}

/// The speeds of both wheels in thousandths of an r/min.
fn speeds_of(path: &str) -> [Vec<i64>; 2] {
    let bytes = std::fs::read(path).expect("the MCAP file");
    let mut speeds = [Vec::new(), Vec::new()];
    for message in mcap::MessageStream::new(&bytes).expect("an MCAP file") {
        let message = message.expect("a message");
        let wheel = match message.channel.topic.as_str() {
            "/axis/left_rpm" => 0,
            "/axis/right_rpm" => 1,
            _ => continue,
        };
        let schema = message.channel.schema.as_ref().expect("a schema");
        assert_eq!(schema.name, "motionctl.Wheel");
        let json: serde_json::Value = serde_json::from_slice(&message.data).expect("JSON");
        let speed = json["speed"].as_f64().expect("a speed");
        speeds[wheel].push((speed * 1e3).round() as i64);
    }
    speeds
}

#[test]
fn the_path_of_a_vehicle_is_recorded_too() {
    let folder = Folder::new("vehicle");
    let twists = concat!(
        env!("CARGO_MANIFEST_DIR"),
        "/../../examples/square-twist.csv"
    );
    let words = [
        "sim",
        "--drives",
        "zlac",
        "--twist",
        twists,
        "--track",
        "0.4",
        "--wheel-radius",
        "0.085",
        "--report",
        folder.as_str(),
    ];
    let output = motionctl(&words);
    assert_eq!(output.status.code(), Some(0), "{output:?}");
    let page = Page::in_folder(folder.as_str());
    let facts = page.data()["facts"].to_string();
    assert!(facts.contains("Odometry: x "), "{facts}");
}

#[test]
fn the_live_view_shows_wheels_in_revolutions_and_stops_them() {
    let words = ["sim", "--drives", "zlac", "--live"];
    let mut view = OnScreen::start(&words, 80, 24);
    let screen = view.wait_for("two streaming wheels", |text| {
        text.matches("streaming").count() >= 2
    });
    for wanted in [
        "node",
        "wheel",
        "r/min",
        "a alarm",
        "p pull/plug",
        "s stop",
        "f [ ] time",
    ] {
        assert!(screen.contains(wanted), "{wanted} in\n{screen}");
    }
    assert!(!screen.contains("space pause"), "{screen}");
    view.press("s");
    view.wait_for("the end", |text| text.contains("until the user stopped"));
    view.press("q");
    let (status, shown) = view.wait();
    assert_eq!(status.code(), Some(0), "{shown}");
}

#[test]
fn a_recording_is_never_written_over_another() {
    let folder = Folder::new("wheels-twice");
    std::fs::create_dir_all(&folder.0).expect("a folder");
    let file = folder.file("x");
    let words = [
        "sim",
        "--drives",
        "zlac",
        "--csv",
        &file,
        "--candump",
        &file,
    ];
    let output = motionctl(&words);
    assert_eq!(output.status.code(), Some(2), "{output:?}");
    assert!(
        text(&output.stderr).contains("is given twice"),
        "{output:?}"
    );
}
