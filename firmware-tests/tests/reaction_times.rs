//! How long it takes from a cause to the last step of a drive and to drives without power, whenever in a cycle the cause comes: the tables of
//! docs/safety-functions.md. `REACTION_TIMES=write` writes the table of the board in the place of comparing with it.

use std::fmt;
use std::path::{Path, PathBuf};

use drive_sim::FrameMatch;
use dyn_can::{Alarm, Dialect, PdStep, Request};
use firmware_tests::chip::Controller;
use firmware_tests::rig::MS;
use firmware_tests::{Contact, Rig, fault, rig};

const AXES: i32 = 8;
/// When in a cycle of a millisecond a cause comes: the first one while the inputs are read.
const PHASES_US: [u64; 4] = [0, 130, 480, 870];
/// Drives that are not off by then stay on: they hold.
const WATCHED_MS: u64 = 1_500;
const STEP_US: u64 = 500;
/// What another compiler changes.
const TOLERANCE_US: u64 = 300;

/// What happens to a machine in motion.
struct Cause {
    name: &'static str,
    image: &'static str,
    axes: i32,
    happens: fn(&mut Rig),
}

impl Cause {
    const fn of_drives(name: &'static str, happens: fn(&mut Rig)) -> Self {
        Self {
            name,
            image: "axes-8",
            axes: AXES,
            happens,
        }
    }

    const fn of_firmware(name: &'static str, happens: fn(&mut Rig)) -> Self {
        Self {
            name,
            image: "misbehaving",
            axes: 2,
            happens,
        }
    }
}

static CAUSES: [Cause; 10] = [
    Cause::of_drives("the stop circuit opens", |rig| rig.open(Contact::Stop)),
    Cause::of_drives("enable is released", |rig| rig.open(Contact::Enable)),
    Cause::of_drives("run is released", |rig| rig.open(Contact::Run)),
    Cause::of_drives("a drive reports an alarm", |rig| {
        let drive = rig.drives()[3];
        let faults = rig.servo_mut(drive).faults_mut();
        faults.raise_alarm(Alarm::OverCurrent);
    }),
    Cause::of_drives("a drive leaves the bus", |rig| {
        let drive = rig.drives()[3];
        rig.servo_mut(drive).faults_mut().leave_bus();
    }),
    Cause::of_drives("every drive leaves the bus", |rig| {
        for drive in rig.drives().to_vec() {
            rig.servo_mut(drive).faults_mut().leave_bus();
        }
    }),
    Cause::of_drives("the controller is pushed off the bus", |rig| {
        let frames = FrameMatch::sent_by(rig.board().soc().can.node());
        let faults = rig.wire_mut().bus_mut().faults_mut();
        faults.corrupt_next(frames, 32, 20);
    }),
    Cause::of_firmware("the crystal stops", |rig| {
        rig.board_mut().soc_mut().lose_crystal();
    }),
    Cause::of_firmware("the firmware does not come to the end of a cycle", |rig| {
        rig.board_mut().poke("MISBEHAVE", 1);
    }),
    Cause::of_firmware("the firmware panics", |rig| {
        rig.board_mut().poke("MISBEHAVE", 2);
    }),
];

/// The longest times of a cause, in microseconds; nothing where no step came any more, or where the drives stay on.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq)]
struct Reaction {
    last_step_us: Option<u64>,
    off_us: Option<u64>,
}

fn longest(cause: &Cause, change: fn(&mut Rig)) -> Reaction {
    let mut longest = Reaction::default();
    for phase_us in PHASES_US {
        let mut rig = Rig::with_numbered_drives(rig::image(cause.image), cause.axes);
        change(&mut rig);
        rig.bring_up();
        rig.run_us(phase_us);
        let reaction = react(&mut rig, cause.happens);
        longest.last_step_us = longest.last_step_us.max(reaction.last_step_us);
        longest.off_us = longest.off_us.max(reaction.off_us);
    }
    longest
}

fn react(rig: &mut Rig, happens: fn(&mut Rig)) -> Reaction {
    let at_ns = rig.board().soc().now_ns();
    happens(rig);
    let mut off_us = None;
    for step in 1..=WATCHED_MS * 1_000 / STEP_US {
        rig.run_us(STEP_US);
        if rig.servos().all(|drive| !drive.is_enabled()) {
            off_us = Some(step * STEP_US);
            break;
        }
    }
    // Nothing may follow.
    rig.run_ms(100);
    let steps = rig.set_points_since(at_ns).filter(|record| {
        let frame = dyn_can::DataFrame::from_can(&record.frame).expect("a data frame");
        let still = PdStep::new(0).map(Request::GoRelativePosPd);
        Request::decode(&frame, &Dialect::V1_6A).map(|(_, request)| request)
            != still.map_err(|_| unreachable!())
    });
    Reaction {
        last_step_us: steps
            .map(|record| (record.end_ns - at_ns).div_ceil(1_000))
            .max(),
        off_us,
    }
}

/// Milliseconds, to the next tenth above.
fn ms(us: Option<u64>, nothing: &str) -> String {
    us.map_or(nothing.to_owned(), |us| {
        let tenths = us.div_ceil(100);
        format!("{}.{}", tenths / 10, tenths % 10)
    })
}

struct Row(&'static str, Reaction);

impl fmt::Display for Row {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let Self(name, reaction) = self;
        let last = ms(reaction.last_step_us, "none follows");
        let off = ms(reaction.off_us, "they hold");
        write!(f, "| {name} | {last} | {off} |")
    }
}

fn page() -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("../docs/safety-functions.md")
}

fn marks() -> [String; 2] {
    let board = match rig::chip().controller {
        Controller::BxCan => "stm32f405",
        Controller::FdCan => "stm32g474",
    };
    ["begin", "end"].map(|which| format!("<!-- {which}: {board} -->\n"))
}

/// The table of this board, from the page.
fn documented() -> String {
    let text = std::fs::read_to_string(page()).expect("the page");
    let [begin, end] = marks();
    let table = text.split(&begin).nth(1).expect("its table");
    table.split(&end).next().expect("its end").to_owned()
}

fn write(table: &str) {
    let text = std::fs::read_to_string(page()).expect("the page");
    let [begin, end] = marks();
    let (before, rest) = text.split_once(&begin).expect("its table");
    let (_, after) = rest.split_once(&end).expect("its end");
    std::fs::write(page(), format!("{before}{begin}{table}{end}{after}")).expect("it is written");
}

/// What the page has for a cause.
fn row_of(name: &str) -> Reaction {
    let table = documented();
    let mut rows = table.lines().map(|line| line.split('|').map(str::trim));
    let row = rows.find(|row| row.clone().nth(1) == Some(name));
    let cells: Vec<&str> = row.unwrap_or_else(|| panic!("no row: {name}")).collect();
    let us = |cell: &str| cell.parse::<f64>().ok().map(|ms| (ms * 1e3).round() as u64);
    Reaction {
        last_step_us: us(cells[2]),
        off_us: us(cells[3]),
    }
}

fn agrees(measured: Option<u64>, documented: Option<u64>) -> bool {
    match (measured, documented) {
        (Some(measured), Some(documented)) => {
            measured <= documented + TOLERANCE_US && documented <= measured + TOLERANCE_US
        }
        (None, None) => true,
        _ => false,
    }
}

fn is_documented(name: &str, measured: Reaction) -> bool {
    let row = row_of(name);
    agrees(measured.last_step_us, row.last_step_us) && agrees(measured.off_us, row.off_us)
}

#[test]
fn every_reaction_takes_as_long_as_the_page_says() {
    let threads = CAUSES
        .iter()
        .map(|cause| std::thread::spawn(|| longest(cause, |_| {})));
    let threads: Vec<_> = threads.collect();
    let measured = threads
        .into_iter()
        .map(|thread| thread.join().expect("it is measured"));
    let rows: Vec<Row> = CAUSES
        .iter()
        .zip(measured)
        .map(|(cause, reaction)| Row(cause.name, reaction))
        .collect();
    let lines: String = rows.iter().map(|row| format!("{row}\n")).collect();
    let head = "| Cause | last step, ms | off, ms |\n|---|---|---|\n";
    if std::env::var("REACTION_TIMES").as_deref() == Ok("write") {
        write(&format!("{head}{lines}"));
        return;
    }
    for Row(name, reaction) in rows {
        assert!(
            is_documented(name, reaction),
            "{name}: {reaction:?}, the page has {:?}",
            row_of(name)
        );
    }
}

#[test]
fn a_firmware_that_seldom_looks_at_the_stop_circuit_is_noticed() {
    let cause = Cause {
        image: "misbehaving",
        axes: 2,
        ..Cause::of_drives("the stop circuit opens", |rig| rig.open(Contact::Stop))
    };
    let seldom = longest(&cause, |rig| rig.put_back(fault::SELDOM_STOP));
    assert!(seldom.last_step_us > Some(2 * MS / 1_000), "{seldom:?}");
    assert!(!is_documented(cause.name, seldom));
}
