//! Programs on machines that are more than one motor an axis: gantries, differential drives, backlash; judged by the frames on the bus.

#[path = "../../path/tests/independent/judge.rs"]
mod judge;
mod tool;

use judge::judge;
use tool::{Folder, Scratch, bus, motionctl, text};

const COUNTS_PER_MM: f64 = 3_276.8;

const GANTRY: &str = "machine = \"gantry\"
[[motor]]
drive = 1
axis = \"X\"
mm-per-turn = 5
[[motor]]
drive = 2
axis = \"X\"
mm-per-turn = 5
gear-ratio = -1
[[motor]]
drive = 3
axis = \"Y\"
mm-per-turn = 5
backlash-mm = 0.02
";

const WHEELS: &str = "machine = \"differential-drive\"
[[motor]]
drive = 2
side = \"right\"
counts-per-mm = -400
[[motor]]
drive = 1
side = \"left\"
counts-per-mm = 400
";

/// There and back in both coordinates, with an arc, and a pause in between.
const PROGRAM: &str = "G21 G90 G64 P0.05
G1 X20 Y5 F3000
G4 P0.3
G1 X5 Y15
G3 X5 Y5 I0 J-5
G1 X0 Y0
M2
";

/// Positions of the drives of a program on a machine, or on its own options.
fn played(name: &str, program: &str, more: &[&str], drives: usize) -> Vec<Vec<f64>> {
    let file = Scratch::new(&format!("{name}.ngc"), program);
    let log = Scratch::new(&format!("{name}.log"), "");
    let mut words = vec!["sim", "--program", file.as_str()];
    words.extend(["--candump", log.as_str()]);
    words.extend(more);
    let output = motionctl(&words);
    assert_eq!(output.status.code(), Some(0), "{}", text(&output.stderr));
    bus::positions(log.as_str(), drives)
}

/// 500 r/min, 5000 r/min per second, 100000 r/min per second², in counts and cycles.
fn limits() -> [f64; 3] {
    let turn = 16_384.0 / 60.0;
    [500.0 * turn / 1e3, 5e3 * turn / 1e6, 1e5 * turn / 1e9]
}

#[test]
fn both_motors_of_a_gantry_go_the_same_way_and_the_play_is_taken_up() {
    let machine = Scratch::new("gantry.toml", GANTRY);
    let axes = played("gantry", PROGRAM, &["--machine", machine.as_str()], 3);
    judge("gantry", &axes, &[limits(); 3], 0.5);
    let [one, other, across] = &axes[..] else {
        panic!("three drives")
    };
    let farthest = one.iter().copied().fold(0.0, f64::max);
    assert!(farthest > 19.9 * COUNTS_PER_MM, "{farthest}");
    for (one, other) in one.iter().zip(other) {
        assert!((one + other).abs() <= 1.0, "{one} {other}");
    }
    // Half of 0.02 mm on either side, from the middle and back to it.
    let highest = across.iter().copied().fold(0.0, f64::max);
    assert!((highest - 15.01 * COUNTS_PER_MM).abs() < 170.0, "{highest}");
    assert!(highest > 15.0 * COUNTS_PER_MM - 130.0, "{highest}");
    assert_eq!(
        axes.iter()
            .map(|axis| axis[axis.len() - 1])
            .collect::<Vec<_>>(),
        [0.0; 3]
    );
    // While it stands behind the first move, and again before the end.
    let standing: Vec<f64> = across
        .windows(200)
        .filter(|part| part.iter().all(|at| *at == part[0]))
        .map(|part| part[0])
        .collect();
    assert!(
        standing.contains(&(5.01 * COUNTS_PER_MM).round()),
        "{standing:?}"
    );
}

/// Where an axis turns with its largest acceleration, taking up the play comes on top.
#[test]
fn turns_with_a_play_keep_the_limits_of_the_motor() {
    let machine = "machine = \"cartesian\"
[[motor]]
drive = 1
axis = \"Y\"
mm-per-turn = 5
backlash-mm = 0.5
";
    let machine = Scratch::new("play.toml", machine);
    let program = "G21 G90 F9000\nG1 Y10\nY0\nY4\nY-4\nY3\nY0\nM2\n";
    let axes = played("play", program, &["--machine", machine.as_str()], 1);
    judge("play", &axes, &[limits()], 0.5);
    let farthest = axes[0].iter().copied().fold(0.0, f64::max);
    assert!(farthest > 10.2 * COUNTS_PER_MM, "{farthest}");
}

#[test]
fn a_machine_without_anything_special_is_what_the_options_say() {
    let plain = "machine = \"cartesian\"
[[motor]]
drive = 1
axis = \"X\"
mm-per-turn = 5
[[motor]]
drive = 2
axis = \"Y\"
counts-per-mm = 3276.8
";
    let machine = Scratch::new("plain.toml", plain);
    let with_file = played("plain", PROGRAM, &["--machine", machine.as_str()], 2);
    let options = ["--axes", "2", "--mm-per-turn", "5"];
    assert_eq!(with_file, played("options", PROGRAM, &options, 2));
}

#[test]
fn wheels_drive_ahead_turn_and_drive_an_arc() {
    let machine = Scratch::new("wheels.toml", WHEELS);
    let program = "G21 G91 G61\nG1 X300 F6000\nG1 Y200\nG1 X100 Y-100\nM2\n";
    let axes = played("wheels", program, &["--machine", machine.as_str()], 2);
    judge("wheels", &axes, &[limits(); 2], 0.5);
    let wheels = axes[0].iter().zip(&axes[1]);
    let places: Vec<[f64; 2]> = wheels
        .map(|(left, right)| [left / 400.0, -right / 400.0])
        .collect();
    let near = |a: f64, b: f64| (a - b).abs() < 0.01;
    for [left, right] in &places {
        let (ahead, turned) = ((left + right) / 2.0, right - left);
        let is_ahead = near(turned, 0.0) && ahead <= 300.01;
        let is_turning = near(ahead, 300.0);
        let is_on_arc = near(turned, 200.0 - (ahead - 300.0));
        assert!(is_ahead || is_turning || is_on_arc, "{ahead} {turned}");
    }
    let [left, right] = places[places.len() - 1];
    assert!(near(left, 350.0) && near(right, 450.0), "{left} {right}");
}

#[test]
fn reports_name_the_motors() {
    let (machine, program) = (
        Scratch::new("report.toml", GANTRY),
        Scratch::new("report.ngc", PROGRAM),
    );
    let folder = Folder::new("machine-report");
    let mut words = vec!["sim", "--json", "--report", folder.as_str(), "--program"];
    words.extend([program.as_str(), "--machine", machine.as_str()]);
    let output = motionctl(&words);
    assert_eq!(output.status.code(), Some(0), "{}", text(&output.stderr));
    let json: serde_json::Value = serde_json::from_slice(&output.stdout).expect("JSON");
    let axes = json["motion"]["axes"].as_array().expect("axes");
    let names: Vec<&str> = axes
        .iter()
        .filter_map(|axis| axis["axis"].as_str())
        .collect();
    assert_eq!(names, ["X1", "X2", "Y"]);
    assert_eq!(axes[1]["counts_per_mm"], -COUNTS_PER_MM);
    assert_eq!(axes[2]["backlash_mm"], 0.02);
    let page = std::fs::read_to_string(folder.file("index.html")).expect("a page");
    assert!(page.contains("X2"));
}

/// Why a machine is refused.
fn refused(machine: &str, more: &[&str]) -> String {
    let program = Scratch::new("refused.ngc", PROGRAM);
    let file = Scratch::new("refused.toml", machine);
    let mut words = vec![
        "sim",
        "--program",
        program.as_str(),
        "--machine",
        file.as_str(),
    ];
    words.extend(more);
    let output = motionctl(&words);
    assert_eq!(output.status.code(), Some(2), "{output:?}");
    assert!(output.stdout.is_empty(), "nothing may run: {output:?}");
    let errors = text(&output.stderr).replace(file.as_str(), "FILE");
    errors.trim().to_owned()
}

#[test]
fn a_machine_that_contradicts_itself_is_refused_with_its_place() {
    let x = "[[motor]]\ndrive = 1\naxis = \"X\"\nmm-per-turn = 5\n";
    let y = "[[motor]]\ndrive = 2\naxis = \"Y\"\nmm-per-turn = 5\n";
    let left = "[[motor]]\ndrive = 1\nside = \"left\"\nmm-per-turn = 5\n";
    let cartesian = |motors: &[&str]| format!("machine = \"cartesian\"\n{}", motors.concat());
    let wheels = |motors: &[&str]| format!("machine = \"differential-drive\"\n{}", motors.concat());
    let left_of_two = &left.replace("drive = 1", "drive = 2");
    let x_again = &x.replace("drive = 1", "drive = 2");
    for (machine, says) in [
        (
            "machine = \"delta\"\nmotor = []\n".to_owned(),
            "line 1, column 11: expected \"cartesian\", \"gantry\" or \"differential-drive\", got \"delta\"",
        ),
        (
            cartesian(&[x, x_again]),
            "line 8, column 8: expected one motor of X, got another one; for two motors on one axis write machine = \"gantry\"",
        ),
        (
            cartesian(&[x, &y.replace("drive = 2", "drive = 1")]),
            "line 7, column 9: expected each drive once, got drive 1 a second time",
        ),
        (
            cartesian(&[x, left_of_two]),
            "line 8, column 8: expected axis = \"X\" or \"Y\" or \"Z\", got \"left\" of another machine",
        ),
        (
            cartesian(&[&x.replace("\"X\"", "\"A\"")]),
            "line 4, column 8: expected axis = \"X\" or \"Y\" or \"Z\", got \"A\"",
        ),
        (
            cartesian(&["[[motor]]\ndrive = 1\nmm-per-turn = 5\n"]),
            "line 2, column 1: expected axis = \"X\" or \"Y\" or \"Z\", got nothing",
        ),
        (
            cartesian(&[x, "counts-per-mm = 100\n"]),
            "line 5, column 15: expected counts-per-mm or mm-per-turn, got both",
        ),
        (
            cartesian(&[&x.replace("mm-per-turn = 5", "rpm = 5")]),
            "line 2, column 1: expected mm-per-turn or counts-per-mm, got neither",
        ),
        (
            cartesian(&[&x.replace("mm-per-turn = 5", "counts-per-mm = 5\ngear-ratio = 2")]),
            "line 6, column 14: expected counts-per-mm or gear-ratio, got both",
        ),
        (
            cartesian(&[x, "rpm = -5\n"]),
            "line 6, column 7: expected a number above 0, got -5",
        ),
        (
            cartesian(&[x, "backlash-mm = nan\n"]),
            "line 6, column 15: expected a number above 0, got NaN",
        ),
        (
            cartesian(&[x, "gear-ratio = 0\n"]),
            "line 6, column 14: expected a finite number other than 0, got 0",
        ),
        (
            cartesian(&[x, "counts-per-turn = 1000\n"]),
            "line 6, column 19: expected 4 times the gear number of the drive, 2000 to 65536, got 1000",
        ),
        (
            cartesian(&[&x.replace("drive = 1", "drive = 64")]),
            "line 3, column 9: expected a drive id from 1 to 63, got 64",
        ),
        (
            cartesian(&[x, "speed = 5\n"]),
            "line 6, column 1: expected a machine and its motors, got unknown field `speed`",
        ),
        (
            cartesian(&[x, "rpm = fast\n"]),
            "line 6, column 7: expected a machine and its motors, got",
        ),
        (
            "machine = \"cartesian\"\nmotor = []\n".to_owned(),
            "line 1, column 11: expected a [[motor]], got none",
        ),
        (
            format!("machine = \"gantry\"\n{x}{y}"),
            "line 1, column 11: expected two motors on one axis of a gantry, got one on each",
        ),
        (
            wheels(&[left]),
            "line 1, column 11: expected two motors, left and right, got one",
        ),
        (
            wheels(&[left, left_of_two]),
            "line 8, column 8: expected one motor of left, got another one",
        ),
        (
            wheels(&[left, y]),
            "line 8, column 8: expected side = \"left\" or \"right\", got \"Y\" of another machine",
        ),
        // What the master and the path cannot do.
        (
            cartesian(&[x, y, "rpm = 1e9\n"]),
            "line 6, column 1: motor of drive 2: ",
        ),
        (
            cartesian(&[x, "backlash-mm = 1e12\n"]),
            "line 2, column 1: motor of drive 1: a backlash of 1000000000000 mm: ",
        ),
        (
            cartesian(&[x]),
            "line 2, column 8: the machine has no axis Y",
        ),
    ] {
        let actual = refused(&machine, &[]);
        assert!(actual.contains(says), "{machine}{actual}\n{says}");
    }
}

#[test]
fn options_that_a_machine_says_are_refused_beside_it() {
    for option in [
        &["--axes", "2"][..],
        &["--mm-per-turn", "5"],
        &["--counts-per-mm", "5"],
        &["--gear-ratio", "2"],
        &["--counts-per-turn", "16384"],
        &["--axis-rpm", "100"],
        &["--axis-acceleration", "100"],
        &["--axis-jerk", "100"],
        &["--drives", "1,2,3"],
    ] {
        let error = refused(GANTRY, option);
        assert!(error.contains("cannot be used with"), "{option:?}: {error}");
    }
    let error = refused(GANTRY, &["--bus", "a=1,2", "--bus", "b=1"]);
    assert!(
        error.contains("its motors have the drives 1, 2, 3, and not 1, 2, 1"),
        "{error}"
    );
    let file = Scratch::new("no-program.toml", GANTRY);
    let output = motionctl(&["sim", "--machine", file.as_str()]);
    assert_eq!(output.status.code(), Some(2));
    assert!(text(&output.stderr).contains("--program"), "{output:?}");
}
