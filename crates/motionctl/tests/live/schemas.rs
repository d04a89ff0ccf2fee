//! What the commands print with `--json` has the shape that `motionctl schema` says, each of them.

use std::collections::BTreeSet;
use std::path::Path;
use std::process::Output;

use serde_json::Value;

use crate::bench::{BenchProcess, Scratch, interrupt, motionctl, start_and_wait_for};
use crate::board_home::HERE;
use crate::board_line::{BoardBench, SETTINGS};
use crate::tool::{Folder, text};
use crate::undisturbed::undisturbed;

const MOTION: &str = "time_s,a,b\n0,0,0\n0.2,20,-10\n0.4,0,0\n";
const WHEELS: &str = "time_s,a,b\n0,0,0\n0.2,20,-10\n0.4,0,0\n";
const TWISTS: &str = "time_s,speed_m_s,turn_rad_s\n0,0,0\n0.2,0.1,0\n0.4,0,0\n";

/// The names whose schema was compared.
#[derive(Default)]
struct Seen(BTreeSet<String>);

impl Seen {
    /// Every document on the output is what the schema says.
    fn compare(&mut self, name: &str, output: &Output) {
        let status = output.status.code();
        assert!(matches!(status, Some(0 | 1)), "{name}: {output:?}");
        let documents = serde_json::Deserializer::from_slice(&output.stdout).into_iter::<Value>();
        let mut count = 0;
        for document in documents {
            let document = document.unwrap_or_else(|error| panic!("{name}: {error}: {output:?}"));
            self.check(name, &document);
            count += 1;
        }
        assert!(count > 0, "{name}: nothing was printed: {output:?}");
    }

    /// This document is what the schema says.
    fn check(&mut self, name: &str, document: &Value) {
        let schema = motionctl(&["schema", name]).output().expect("it runs");
        let schema: Value = serde_json::from_slice(&schema.stdout).expect("a schema");
        let validator = jsonschema::validator_for(&schema).expect("a schema that is one");
        let wrong: Vec<String> = validator
            .iter_errors(document)
            .map(|error| format!("{}: {error}", error.instance_path()))
            .collect();
        assert!(wrong.is_empty(), "{name}: {wrong:#?}\n{document:#}");
        self.0.insert(name.to_owned());
    }

    fn run(&mut self, name: &str, words: &[&str]) {
        let output = motionctl(&[words, &["--json"]].concat());
        self.compare(name, &{ output }.output().expect("it runs"));
    }

    /// On a bench, which has drives of the family.
    fn on(&mut self, bench: &BenchProcess, name: &str, family: &[&str], words: &[&str]) {
        let (command, options) = words.split_first().expect("a command");
        let link = [*command, "--slcan", bench.path()];
        self.run(name, &[&link[..], family, options].concat());
    }

    /// What holds until Ctrl-C.
    fn until_interrupted(&mut self, bench: &BenchProcess, name: &str, words: &[&str], said: &str) {
        let (command, options) = words.split_first().expect("a command");
        let link = [*command, "--slcan", bench.path(), "--json"];
        let child = start_and_wait_for(motionctl(&[&link[..], options].concat()), said);
        interrupt(&child);
        self.compare(name, &child.wait_with_output().expect("it ends"));
    }

    /// Every name that begins so, or does not, was compared.
    fn have_all(&self, zlac: bool) {
        let names = motionctl(&["schema"]).output().expect("it runs");
        let names = text(&names.stdout).lines();
        let wanted: BTreeSet<String> = names
            .filter(|name| name.starts_with("zlac-") == zlac)
            .map(str::to_owned)
            .collect();
        assert_eq!(self.0, wanted);
    }
}

#[test]
fn what_the_commands_for_servo_drives_print_is_what_their_schemas_say() {
    undisturbed(|| {
        let mut seen = Seen::default();
        let folder = Folder::new("schemas");
        std::fs::create_dir_all(&folder.0).expect("a folder");
        offline(&mut seen, &folder);
        let bench = BenchProcess::start("schemas-servos", "1,2");
        bench.disable("1,2");
        let (settings, origins) = (folder.file("machine.toml"), folder.file("origins.toml"));
        let motion = Scratch::new("schemas.csv", MOTION);
        let one = ["--drive", "1", "--yes"];
        let with = |command: &'static str, options: &[&'static str]| {
            [&[command][..], &one, options].concat()
        };
        seen.on(&bench, "scan", &[], &["scan"]);
        seen.on(&bench, "read", &[], &["read", "--drive", "1"]);
        let monitor = ["monitor", "--drives", "1,2", "--count", "2"];
        seen.on(&bench, "monitor", &[], &monitor);
        let backup = ["backup", &settings, "--drives", "1,2"];
        seen.on(&bench, "backup", &[], &backup);
        seen.on(&bench, "restore", &[], &["restore", &settings, "--yes"]);
        let write = with("write", &["max-speed=21"]);
        seen.on(&bench, "write", &[], &write);
        seen.on(&bench, "restore", &[], &["restore", &settings, "--yes"]);
        seen.on(&bench, "origin", &[], &with("origin", &[]));
        seen.on(&bench, "probe", &[], &with("probe", &[]));
        seen.on(&bench, "jog", &[], &with("jog", &["--turns", "0.1"]));
        let moves = ["move", "--drives", "1,2", "--by", "0.1,0.1", "--yes"];
        // The drives come with a high speed and acceleration of their own.
        let limits = ["--max-rpm", "600", "--max-acceleration", "100000"];
        let moves = [&moves[..], &limits].concat();
        seen.on(&bench, "move", &[], &moves);
        let speed = [
            "speed", "--drives", "1", "--rpm", "10", "--for", "1", "--yes",
        ];
        // A drive as delivered changes its speed by a little more than the tool allows unasked.
        let speed = [&speed[..], &["--max-acceleration", "2000"]].concat();
        seen.on(&bench, "speed", &[], &speed);
        let tune = with("tune", &["--periods", "1"]);
        seen.on(&bench, "tune", &[], &tune);
        let home = [
            "--method",
            "here",
            "--travel",
            "-1:1",
            "--origins",
            &origins,
        ];
        let home = [&with("home", &[])[..], &home].concat();
        seen.on(&bench, "home", &[], &home);
        let run = [
            "run",
            "--trajectory",
            motion.path(),
            "--drives",
            "1,2",
            "--yes",
        ];
        seen.on(&bench, "run", &[], &run);
        let enable = ["enable", "--drives", "1,2", "--yes"];
        seen.until_interrupted(&bench, "enable", &enable, "enabled and hold");
        let record = ["record", "--folder", folder.as_str()];
        seen.until_interrupted(&bench, "record", &record, "until Ctrl-C");
        seen.on(&bench, "disable", &[], &["disable", "--drives", "1,2"]);
        seen.on(&bench, "reset", &[], &with("reset", &[]));
        seen.on(
            &bench,
            "assign-id",
            &[],
            &["assign-id", "--from", "2", "--to", "5", "--yes"],
        );
        seen.compare("bench", &bench.end());
        on_board(&mut seen);
        seen.have_all(false);
    });
}

/// What the words of a board print.
fn on_board(seen: &mut Seen) {
    let bench = BoardBench::start("schemas-board", SETTINGS);
    let motion = Scratch::new("schemas-board.csv", MOTION);
    let port = ["--port", bench.port()];
    let mut on = |name: &str, words: &[&str]| seen.run(name, &[&["board"], words, &port].concat());
    on("board-find", &["find"]);
    on("board-info", &["info"]);
    on("board-monitor", &["monitor", "--count", "2"]);
    on("board-faults", &["faults"]);
    on("board-settings", &["settings", "get"]);
    on(
        "board-settings",
        &["settings", "check", bench.settings_path()],
    );
    let homed = BoardBench::start_with("schemas-home", HERE, &[]);
    let port_of_homed = ["--port", homed.port()];
    seen.run(
        "board-home",
        &[&["board", "home", "--yes"], &port_of_homed[..]].concat(),
    );
    drop(homed);
    let mut on = |name: &str, words: &[&str]| seen.run(name, &[&["board"], words, &port].concat());
    on("board-run", &["run", motion.path(), "--yes"]);
    // Nothing comes in.
    on("board-stream", &["stream", "--yes"]);
    on("board-stop", &["stop"]);
    on("board-halt", &["halt"]);
    on("board-disable", &["disable"]);
    on("board-clear", &["clear"]);
    let (report, _) = bench.end();
    seen.check("bench", &report);
}

/// What needs no drive.
fn offline(seen: &mut Seen, folder: &Folder) {
    let motion = Scratch::new("schemas-offline.csv", MOTION);
    let program = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../examples/programs/slot.ngc");
    let program = program.to_str().expect("plain text");
    let log = folder.file("sim.log");
    let sim = ["sim", "--trajectory", motion.path()];
    seen.run("sim", &[&sim[..], &["--candump", &log]].concat());
    seen.run("decode", &["decode", &log]);
    std::fs::write(
        folder.file("damaged.log"),
        "(0.1) can0 03C#FF88\nnothing\nnothing\n(0.2) can0 03C#FF\n",
    )
    .expect("a log");
    seen.run("decode", &["decode", &folder.file("damaged.log")]);
    seen.run("plan", &["plan", "--axes", "4"]);
    seen.run("limits", &["limits", "--cycles", "200"]);
    seen.run("check", &["check", "--trajectory", motion.path()]);
    let keyframes = folder.file("part.rs");
    let keyframes = ["keyframes", &keyframes, "--program", program];
    seen.run(
        "keyframes",
        &[&keyframes[..], &["--axes", "2", "--mm-per-turn", "5"]].concat(),
    );
    let none = ["write", "--can", "none", "--drive", "1"];
    seen.run(
        "dry-run",
        &[&none[..], &["max-speed=21", "--dry-run"]].concat(),
    );
}

#[test]
fn what_the_commands_for_hub_motors_print_is_what_their_schemas_say() {
    undisturbed(|| {
        let mut seen = Seen::default();
        let folder = Folder::new("schemas-zlac");
        std::fs::create_dir_all(&folder.0).expect("a folder");
        let wheels = Scratch::new("schemas-wheels.csv", WHEELS);
        let twists = Scratch::new("schemas-twists.csv", TWISTS);
        let (settings, origins) = (folder.file("machine.toml"), folder.file("origins.toml"));
        let log = folder.file("sim.log");
        let (one, two) = (["--drives", "zlac:4"], ["--drives", "zlac:4,5"]);
        let sim = ["sim", "--drives", "zlac", "--candump", &log];
        seen.run("zlac-sim", &sim);
        let mut decoded = Seen::default();
        decoded.run("decode", &["decode", "--protocol", "canopen", &log]);
        let vehicle = ["--track", "0.4", "--wheel-radius", "0.085"];
        let twist = ["--twist", twists.path()];
        let sim = ["sim", "--drives", "zlac"];
        seen.run("zlac-sim", &[&sim[..], &twist, &vehicle].concat());
        seen.run("zlac-plan", &["plan", "--drives", "zlac:4,5"]);
        let bench = BenchProcess::start("schemas-wheels", "zlac:4,5");
        seen.on(
            &bench,
            "zlac-scan",
            &["--drives", "zlac"],
            &["scan", "--yes"],
        );
        seen.on(&bench, "zlac-read", &one, &["read"]);
        seen.on(&bench, "zlac-read", &one, &["read", "6064"]);
        seen.on(&bench, "zlac-monitor", &two, &["monitor", "--count", "2"]);
        seen.on(&bench, "zlac-backup", &two, &["backup", &settings]);
        let write = ["write", "6083=500", "--yes"];
        seen.on(&bench, "zlac-write", &one, &write);
        seen.on(
            &bench,
            "zlac-restore",
            &two,
            &["restore", &settings, "--yes"],
        );
        seen.on(&bench, "zlac-origin", &one, &["origin", "--set", "--yes"]);
        seen.on(
            &bench,
            "zlac-jog",
            &one,
            &["jog", "--turns", "0.1", "--yes"],
        );
        seen.on(&bench, "zlac-move", &one, &["move", "--by", "400", "--yes"]);
        let speed = ["speed", "--rpm", "20", "--for", "0.2", "--yes"];
        seen.on(&bench, "zlac-speed", &one, &speed);
        let tune = ["tune", "--periods", "1", "--yes"];
        seen.on(&bench, "zlac-tune", &one, &tune);
        let home = ["home", "--method", "here", "--travel", "-1:1", "--yes"];
        let home = [&home[..], &["--origins", &origins]].concat();
        seen.on(&bench, "zlac-home", &one, &home);
        let run = ["run", "--yes"];
        let file = ["--trajectory", wheels.path()];
        seen.on(&bench, "zlac-run", &two, &[&run[..], &file].concat());
        let run = [&run[..], &twist, &vehicle].concat();
        seen.on(&bench, "zlac-run", &two, &run);
        let enable = ["enable", "--drives", "zlac:4,5", "--yes"];
        seen.until_interrupted(&bench, "zlac-enable", &enable, "Ctrl-C");
        seen.on(&bench, "zlac-disable", &two, &["disable"]);
        seen.on(&bench, "zlac-reset", &one, &["reset", "--yes"]);
        let assign = ["assign-id", "--from", "4", "--to", "7", "--yes"];
        seen.on(&bench, "zlac-assign-id", &["--drives", "zlac"], &assign);
        seen.compare("zlac-bench", &bench.end());
        seen.have_all(true);
    });
}
