//! The error messages of docs/errors.md are those of the tool.
//!
//! To add one, add an entry to `MESSAGES`; `UPDATE_DOCS=1 cargo test -p motionctl --test errors` writes the page anew.

// Parts of these are for other tests.
#[allow(dead_code)]
#[path = "live/adapter.rs"]
mod adapter;
#[allow(dead_code)]
#[path = "live/bench.rs"]
mod bench;
#[allow(dead_code)]
#[path = "live/relay.rs"]
mod relay;
#[path = "live/terminal.rs"]
mod terminal;
mod tool;
#[path = "live/undisturbed.rs"]
mod undisturbed;

use std::any::Any;
use std::fmt::Write as _;
use std::path::{Path, PathBuf};
use std::process::{Command, Stdio};
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};
use std::thread::JoinHandle;
use std::time::Duration;

use adapter::{FakeAdapter, Manner, Mishap, Stage};
use bench::BenchProcess;
use relay::{Line, Relay};
use terminal::Terminal;
use tool::text;
use undisturbed::undisturbed;

/// What is at the path `port`.
#[derive(Clone, Copy)]
enum Device {
    Nothing,
    /// It answers every line with this one.
    Says(&'static str),
    /// An adapter with drive 1 off and drive 2 on behind it.
    Adapter(Manner),
    /// The same, and drive 2 has an alarm.
    Alarm,
    /// The serial port of drive 1.
    Serial(Line),
}

/// One message: a title, the files and the device it needs, the command that brings it about, its exit status.
struct Message {
    title: &'static str,
    files: &'static [(&'static str, &'static str)],
    device: Device,
    command: &'static [&'static str],
    status: i32,
}

/// One axis whose gear number no drive has.
const BOARD: &str = "format = 1\n\n[bus]\nbit_rate_kbit_per_s = 1000\n\n[[axis]]\ndrive = 1\ngear_number = 4\nspeed_rpm = 150\nacceleration_rpm_per_s = 1000\ntravel_min_millidegrees = -90000\ntravel_max_millidegrees = 90000\n";

const MESSAGES: &[Message] = &[
    Message {
        title: "A value is missing",
        files: &[("motion.csv", "t,a,b\n0,0,0\n0.5,10,\n1,20,0\n")],
        device: Device::Nothing,
        command: &["sim", "--trajectory", "motion.csv"],
        status: 2,
    },
    Message {
        title: "A line is neither a header nor numbers",
        files: &[("motion.csv", "0,x,0\n0.5,10,5\n1,20,0\n")],
        device: Device::Nothing,
        command: &["sim", "--trajectory", "motion.csv"],
        status: 2,
    },
    Message {
        title: "No column is named time",
        files: &[("motion.csv", "x,a,b\n0,0,0\n0.5,10,5\n")],
        device: Device::Nothing,
        command: &["sim", "--trajectory", "motion.csv"],
        status: 2,
    },
    Message {
        title: "Columns without names",
        files: &[("motion.csv", "0 0 0\n1 10 10\n2 20 10\n")],
        device: Device::Nothing,
        command: &["sim", "--trajectory", "motion.csv"],
        status: 2,
    },
    Message {
        title: "A name that may mean an axis or something else",
        files: &[("motion.csv", "t,x,v\n0,0,0\n1,10,10\n")],
        device: Device::Nothing,
        command: &["sim", "--trajectory", "motion.csv"],
        status: 2,
    },
    Message {
        title: "A unit in a name and another in the option",
        files: &[("motion.csv", "time_ms,a_rad\n0,0\n500,1\n")],
        device: Device::Nothing,
        command: &["sim", "--trajectory", "motion.csv", "--unit", "degrees"],
        status: 2,
    },
    Message {
        title: "Millimetres without the travel of a turn",
        files: &[("motion.csv", "time_ms,x_mm\n0,0\n500,10\n")],
        device: Device::Nothing,
        command: &["sim", "--trajectory", "motion.csv"],
        status: 2,
    },
    Message {
        title: "A motion too long to be meant",
        files: &[(
            "motion.csv",
            "t,a\n1700000000000000000,0\n1700000001000000000,20\n",
        )],
        device: Device::Nothing,
        command: &["sim", "--trajectory", "motion.csv"],
        status: 2,
    },
    Message {
        title: "A motion too fast",
        files: &[("motion.csv", "t,a\n0,0\n0.1,360\n")],
        device: Device::Nothing,
        command: &["sim", "--trajectory", "motion.csv", "--max-step", "200"],
        status: 2,
    },
    Message {
        title: "A file that is no log",
        files: &[("notes.txt", "bought a screw\n")],
        device: Device::Nothing,
        command: &["decode", "notes.txt"],
        status: 2,
    },
    Message {
        title: "A log with a header that is not known",
        files: &[(
            "trace.trc",
            ";$FILEVERSION=2.1\n;$COLUMNS=N,O,Q,I,D\n 1 0.0 DT 0029\n",
        )],
        device: Device::Nothing,
        command: &["decode", "trace.trc"],
        status: 2,
    },
    Message {
        title: "Damaged lines of a log",
        files: &[(
            "run.log",
            "(0.1) can0 029#\n(0.2) can0 029#0\n(0.3) can0 029#00\n",
        )],
        device: Device::Nothing,
        command: &["decode", "--statistics-only", "run.log"],
        status: 1,
    },
    Message {
        title: "A port that is not there",
        files: &[],
        device: Device::Nothing,
        command: &["read", "--slcan", "port", "--drive", "1"],
        status: 3,
    },
    Message {
        title: "A port on which nothing answers",
        files: &[],
        device: Device::Says(""),
        command: &["read", "--slcan", "port", "--drive", "1"],
        status: 3,
    },
    Message {
        title: "A device that is no CAN adapter",
        files: &[],
        device: Device::Says("ERROR\r"),
        command: &["read", "--slcan", "port", "--drive", "1"],
        status: 3,
    },
    Message {
        title: "An adapter without the bit rate",
        files: &[],
        device: Device::Adapter(Manner::LAWICEL),
        command: &[
            "read",
            "--slcan",
            "port",
            "--bit-rate",
            "250",
            "--drive",
            "1",
        ],
        status: 3,
    },
    Message {
        title: "An adapter that cannot only listen",
        files: &[],
        device: Device::Adapter(NO_LISTEN),
        command: &["decode", "--slcan", "port"],
        status: 3,
    },
    Message {
        title: "A drive that does not answer",
        files: &[],
        device: Device::Adapter(Manner::LAWICEL),
        command: &["read", "--slcan", "port", "--drive", "4"],
        status: 1,
    },
    Message {
        title: "An alarm before anything is enabled",
        files: &[],
        device: Device::Alarm,
        command: &["enable", "--slcan", "port", "--drives", "1,2", "--yes"],
        status: 1,
    },
    Message {
        title: "Nobody to ask",
        files: &[],
        device: Device::Adapter(Manner::LAWICEL),
        command: &["jog", "--slcan", "port", "--drive", "1", "--turns", "0.25"],
        status: 2,
    },
    Message {
        title: "A setting that never arrived, on a line that echoes",
        files: &[],
        device: Device::Serial(LOSES_SETTINGS),
        command: &[
            "write",
            "--serial",
            "port",
            "--drive",
            "1",
            "main-gain=33",
            "--yes",
        ],
        status: 1,
    },
    Message {
        title: "A drive that does not answer on its serial port",
        files: &[],
        device: Device::Serial(ONLY_ECHOES),
        command: &["read", "--serial", "port", "--drive", "1"],
        status: 1,
    },
    Message {
        title: "A value of a settings file that is out of range",
        files: &[("machine.toml", GAIN_OUT_OF_RANGE)],
        device: Device::Nothing,
        command: &["restore", "machine.toml", "--slcan", "port", "--yes"],
        status: 2,
    },
    Message {
        title: "A key of a settings file that is not known",
        files: &[("machine.toml", UNKNOWN_KEY)],
        device: Device::Nothing,
        command: &["restore", "machine.toml", "--slcan", "port", "--yes"],
        status: 2,
    },
    Message {
        title: "A backup that would replace a file",
        files: &[("machine.toml", "mine\n")],
        device: Device::Nothing,
        command: &["backup", "machine.toml", "--slcan", "port", "--drives", "1"],
        status: 2,
    },
    Message {
        title: "Drives that may not be written",
        files: &[("machine.toml", OTHER_DRIVES)],
        device: Device::Adapter(Manner::LAWICEL),
        command: &["restore", "machine.toml", "--slcan", "port", "--yes"],
        status: 1,
    },
    Message {
        title: "A drive without an id that is not alone",
        files: &[],
        device: Device::Adapter(Manner::LAWICEL),
        command: &[
            "assign-id",
            "--slcan",
            "port",
            "--from",
            "0",
            "--to",
            "5",
            "--yes",
        ],
        status: 1,
    },
    Message {
        title: "Settings that make no board that works",
        files: &[("board.toml", BOARD)],
        device: Device::Nothing,
        command: &[
            "board",
            "settings",
            "check",
            "board.toml",
            "--board",
            "stm32f405",
        ],
        status: 2,
    },
    Message {
        title: "Nothing on the port is a motion board",
        files: &[],
        device: Device::Says("\x07"),
        command: &["board", "info", "--port", "port"],
        status: 3,
    },
];

const GAIN_OUT_OF_RANGE: &str = "\
format = 1
tool = \"motionctl 0.1.0\"
date = 2026-11-29T05:42:14Z

[[drive]]
id = 1
revision = \"1.6A\"
config = 0x00
main-gain = 200
";
const UNKNOWN_KEY: &str = "\
format = 1
tool = \"motionctl 0.1.0\"
date = 2026-11-29T05:42:14Z

[[drive]]
id = 1
revision = \"1.6A\"
main_gain = 20
";
const OTHER_DRIVES: &str = "\
format = 1
tool = \"motionctl 0.1.0\"
date = 2026-11-29T05:42:14Z

[[drive]]
id = 1
revision = \"1.2A\"
config = 0x00
main-gain = 20
speed-gain = 20
integration-gain = 10
torque-filter = 127
max-speed = 60
max-acceleration = 60
on-position-range = 20
gear-number = 4096
line-number = 0

[[drive]]
id = 2
revision = \"1.6A\"
config = 0x00
main-gain = 20
speed-gain = 20
integration-gain = 10
torque-filter = 127
max-speed = 60
max-acceleration = 60
on-position-range = 20
gear-number = 4096
line-number = 0
";
const NO_LISTEN: Manner = Manner {
    knows_listen: false,
    ..Manner::LAWICEL
};
const ONLY_ECHOES: Line = Line {
    echo: Some(Duration::ZERO),
    replies_late: Duration::ZERO,
    drops_settings: false,
    drops_all: true,
    stale: &[],
};
const LOSES_SETTINGS: Line = Line {
    drops_settings: true,
    drops_all: false,
    ..ONLY_ECHOES
};

const BEGIN: &str = "\
# Error messages

One message of each kind, with the files, the device and the command that bring it about. A test of `motionctl` (`tests/errors.rs`) runs the
commands and compares this page with what the tool prints.
";

#[test]
fn the_page_has_the_messages_of_the_tool() {
    let page = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../docs/errors.md");
    if std::env::var_os("UPDATE_DOCS").is_some() {
        std::fs::write(&page, messages()).expect("the page");
    }
    let expected = std::fs::read_to_string(&page).expect("the page");
    undisturbed(|| {
        let actual = messages();
        for (expected, actual) in expected.lines().zip(actual.lines()) {
            assert_eq!(
                expected, actual,
                "run it with UPDATE_DOCS=1 and read what has changed"
            );
        }
        assert_eq!(expected, actual);
    });
}

/// The page as it is to be.
fn messages() -> String {
    let mut page = BEGIN.to_owned();
    for message in MESSAGES {
        write(&mut page, message).expect("a text");
    }
    page
}

fn write(page: &mut String, message: &Message) -> std::fmt::Result {
    let folder = Folder::new();
    writeln!(page, "\n## {}\n", message.title)?;
    for (name, content) in message.files {
        std::fs::write(folder.0.join(name), content).expect("a temporary file");
        writeln!(page, "`{name}`:\n\n```text\n{}```\n", content)?;
    }
    let command = message.command.join(" ");
    let device = Attached::new(message.device, folder.0.join("port"));
    if let Some(text) = &device.text {
        writeln!(page, "{text} is at `port`.\n")?;
    }
    let output = Command::new(env!("CARGO_BIN_EXE_motionctl"))
        .args(message.command)
        .current_dir(&folder.0)
        .stdin(Stdio::null())
        .output()
        .expect("motionctl runs");
    assert_eq!(
        output.status.code(),
        Some(message.status),
        "{}: {output:?}",
        message.title
    );
    let errors = text(&output.stderr);
    assert!(!errors.is_empty(), "{}", message.title);
    writeln!(
        page,
        "`motionctl {command}` ends with exit status {} and says:\n",
        message.status
    )?;
    writeln!(page, "```text\n{errors}```")
}

/// A device that is there until this goes away.
struct Attached {
    _guards: Vec<Box<dyn Any>>,
    /// What it is.
    text: Option<String>,
}

impl Attached {
    fn new(device: Device, link: PathBuf) -> Self {
        let (guards, text): (Vec<Box<dyn Any>>, _) = match device {
            Device::Nothing => (vec![], String::new()),
            Device::Says("") => (
                vec![Box::new(Speaker::start(&link, ""))],
                "A device that stays silent".to_owned(),
            ),
            Device::Says(text) => (
                vec![Box::new(Speaker::start(&link, text))],
                format!("A device that answers `{}` to everything", text.trim_end()),
            ),
            Device::Adapter(manner) => (
                vec![Box::new(FakeAdapter::start_at(link, manner, None))],
                if manner.knows_listen {
                    "An adapter for 1000 kbit/s with drives 1 and 2".to_owned()
                } else {
                    "An adapter without the command `L`".to_owned()
                },
            ),
            Device::Alarm => {
                let alarm = Some((Stage::Looks, Mishap::Alarm(1)));
                let adapter = FakeAdapter::start_at(link, Manner::LAWICEL, alarm);
                let text = "An adapter with drives 1 and 2, of which drive 2 has an alarm,";
                (vec![Box::new(adapter)], text.to_owned())
            }
            Device::Serial(line) => {
                let bench = BenchProcess::start_with_serial("errors-bench", "1", &[]);
                let relay = Relay::start_at(link, &bench, line);
                let text = if line.drops_all {
                    "A two-wire line, which brings back what is sent, without a drive"
                } else {
                    "A two-wire line, which brings back what is sent and loses settings, with drive 1"
                };
                (vec![Box::new(relay), Box::new(bench)], text.to_owned())
            }
        };
        Self {
            _guards: guards,
            text: (!text.is_empty()).then_some(text),
        }
    }
}

/// A device that answers every line with the same bytes.
struct Speaker {
    is_over: Arc<AtomicBool>,
    thread: Option<JoinHandle<()>>,
}

impl Speaker {
    fn start(link: &Path, text: &'static str) -> Self {
        let mut terminal = Terminal::new(link);
        let is_over = Arc::new(AtomicBool::new(false));
        let over = Arc::clone(&is_over);
        let thread = std::thread::spawn(move || {
            while !over.load(Ordering::Relaxed) {
                let heard = terminal.read();
                let lines = heard.iter().filter(|&&byte| byte == b'\r').count();
                terminal.write(&mut text.repeat(lines).into_bytes(), None);
            }
        });
        Self {
            is_over,
            thread: Some(thread),
        }
    }
}

impl Drop for Speaker {
    fn drop(&mut self) {
        self.is_over.store(true, Ordering::Relaxed);
        if let Some(thread) = self.thread.take() {
            let _ = thread.join();
        }
    }
}

/// A folder of its own, so that the messages name files without their folders.
struct Folder(PathBuf);

impl Folder {
    fn new() -> Self {
        let path = std::env::temp_dir().join(format!("motionctl-{}-errors", std::process::id()));
        std::fs::create_dir_all(&path).expect("a temporary folder");
        Self(path)
    }
}

impl Drop for Folder {
    fn drop(&mut self) {
        // Nothing depends on it: the folder is temporary.
        let _ = std::fs::remove_dir_all(&self.0);
    }
}
