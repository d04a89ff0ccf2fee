//! The page `docs/first-drive.md` from its first command to its last, on a simulated drive as it comes out of its box.

use std::path::{Path, PathBuf};
use std::process::Output;
use std::time::Duration;

use rustix::process::Signal;

use crate::bench::{BenchProcess, motionctl, scratch};
use crate::undisturbed::undisturbed;

const PAGE: &str = include_str!("../../../../docs/first-drive.md");
/// The port that the page names.
const PORT: &str = "/dev/ttyACM0";
/// Commands that ask, and are answered with `--yes` here.
const ASKING: [&str; 7] = [
    "assign-id",
    "tune",
    "write",
    "restore",
    "jog",
    "home",
    "run",
];

/// The text of each block of a kind.
fn blocks(kind: &str) -> Vec<&'static str> {
    let fence = format!("```{kind}\n");
    let starts = PAGE.split(fence.as_str()).skip(1);
    starts
        .filter_map(|block| block.split("```").next())
        .collect()
}

/// The commands of the page, without the bench that the test has already.
fn commands() -> Vec<Vec<&'static str>> {
    let lines = blocks("sh").into_iter().flat_map(str::lines);
    lines
        .filter_map(|line| line.split('#').next()?.trim().strip_prefix("motionctl "))
        .map(|line| line.split_whitespace().collect())
        .filter(|words: &Vec<&str>| words.first() != Some(&"bench"))
        .collect()
}

/// A folder that is removed afterwards.
struct Folder(PathBuf);

impl Folder {
    fn new(name: &str) -> Self {
        let path = scratch(name);
        let _ = std::fs::remove_dir_all(&path);
        std::fs::create_dir(&path).expect("a temporary folder");
        Self(path)
    }
}

impl Drop for Folder {
    fn drop(&mut self) {
        // Nothing depends on it: the folder is temporary.
        let _ = std::fs::remove_dir_all(&self.0);
    }
}

fn run(folder: &Path, bench: &BenchProcess, words: &[&str]) -> Output {
    let mut words: Vec<&str> = words
        .iter()
        .map(|&word| if word == PORT { bench.path() } else { word })
        .collect();
    let asks = words.first().is_some_and(|word| ASKING.contains(word));
    if asks && !words.contains(&"--compare") {
        words.push("--yes");
    }
    motionctl(&words)
        .current_dir(folder)
        .output()
        .expect("motionctl runs")
}

fn hour(revision: &str) {
    let folder = Folder::new(&format!("first-hour-folder-{revision}"));
    let motion = blocks("csv");
    let [motion] = motion[..] else {
        panic!("one motion is expected: {motion:?}");
    };
    std::fs::write(folder.0.join("first-motion.csv"), motion).expect("the motion");
    let bench = BenchProcess::start_with(
        &format!("first-hour-{revision}"),
        "",
        &["--fresh", "--stops", "-0.3:2", "--revision", revision],
    );
    for words in commands() {
        let output = run(&folder.0, &bench, &words);
        assert_eq!(output.status.code(), Some(0), "{words:?}: {output:?}");
        match words[0] {
            "assign-id" => {
                bench.signal(Signal::USR1);
                std::thread::sleep(Duration::from_millis(600));
            }
            "write" => {
                let read = run(
                    &folder.0,
                    &bench,
                    &["read", "--slcan", PORT, "--drive", "1"],
                );
                let text = String::from_utf8_lossy(&read.stdout);
                let gain = text.lines().find(|line| line.contains("main-gain"));
                assert!(gain.is_some_and(|line| line.ends_with("25")), "{text}");
            }
            _ => {}
        }
    }
    let report = bench.stop();
    let drive = &report["drives"][0];
    assert_eq!(drive["enabled"], false, "{report}");
    // Back at 90 degrees from the stop, which is 0.3 turns below where it came up.
    let position = drive["position_counts"].as_i64().expect("a number");
    assert!((position - (4_096 - 4_915)).abs() <= 3, "{report}");
    // The id, two gains to compare and back, two gains, and the two gains back.
    assert_eq!(drive["eeprom_writes"], 9, "{report}");
}

#[test]
fn every_step_of_the_page_is_taken() {
    let steps: Vec<&str> = commands().iter().map(|words| words[0]).collect();
    assert_eq!(
        steps,
        [
            "assign-id",
            "scan",
            "read",
            "disable",
            "backup",
            "jog",
            "jog",
            "tune",
            "write",
            "home",
            "jog",
            "plan",
            "run",
            "restore",
            "restore"
        ]
    );
}

#[test]
fn the_first_hour_of_a_drive_of_each_revision() {
    for revision in ["1.2A", "1.6A"] {
        undisturbed(|| hour(revision));
    }
}
