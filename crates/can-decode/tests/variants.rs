//! One conversation written by every tool in many ways: what is read is that conversation, and what is damaged is refused in its line.

use base64::Engine;
use base64::engine::general_purpose::STANDARD;
use can_decode::Frame;
use can_decode::log::{Event, LogReader};
use proptest::prelude::*;
use proptest::sample::select;

/// A frame with its time in microseconds since the first.
#[derive(Debug, Clone)]
struct Heard {
    at_us: u64,
    id: u32,
    extended: bool,
    /// Bytes that a remote frame asks for.
    remote: Option<u8>,
    data: Vec<u8>,
}

impl Heard {
    fn frame(&self) -> Frame {
        match self.remote {
            Some(len) => Frame::remote(self.id, self.extended, len),
            None => Frame::new(self.id, self.extended, &self.data),
        }
        .expect("a classic frame")
    }

    fn len(&self) -> usize {
        self.remote.map_or(self.data.len(), usize::from)
    }

    fn bytes(&self, between: &str) -> String {
        let bytes: Vec<String> = self.data.iter().map(|byte| format!("{byte:02X}")).collect();
        bytes.join(between)
    }

    fn candump_id(&self) -> String {
        if self.extended {
            format!("{:08X}", self.id)
        } else {
            format!("{:03X}", self.id)
        }
    }

    fn asc_id(&self, radix: u32) -> String {
        let id = if radix == 10 {
            self.id.to_string()
        } else {
            format!("{:X}", self.id)
        };
        format!("{id}{}", if self.extended { "x" } else { "" })
    }

    fn trc_id(&self) -> String {
        if self.extended {
            format!("{:08X}", self.id)
        } else {
            format!("{:04X}", self.id)
        }
    }
}

fn frames() -> impl Strategy<Value = Vec<Heard>> {
    let frame = (
        1_u64..30_000,
        any::<u32>(),
        any::<bool>(),
        prop::option::weighted(0.1, 0_u8..=8),
        prop::collection::vec(any::<u8>(), 0..=8),
    );
    prop::collection::vec(frame, 1..12).prop_map(|frames| {
        let mut at_us = 0;
        let heard = frames
            .into_iter()
            .map(|(step, id, extended, remote, data)| {
                at_us += step;
                Heard {
                    at_us,
                    id: if extended {
                        id & 0x1FFF_FFFE
                    } else {
                        id & 0x7FF
                    },
                    extended,
                    data: if remote.is_some() { Vec::new() } else { data },
                    remote,
                }
            });
        heard.collect()
    })
}

/// How the lines look, whatever tool wrote them.
#[derive(Debug, Clone, Copy)]
struct Look {
    blanks: &'static str,
    line_end: &'static str,
    mark: bool,
    colour: bool,
    pick: usize,
}

fn looks() -> impl Strategy<Value = Look> {
    (
        select(&[" ", "  ", "   "][..]),
        select(&["\n", "\r\n"][..]),
        any::<bool>(),
        any::<bool>(),
        any::<usize>(),
    )
        .prop_map(|(blanks, line_end, mark, colour, pick)| Look {
            blanks,
            line_end,
            mark,
            colour,
            pick,
        })
}

/// A log: its header lines, a line for each frame, whether it has times.
struct Log {
    header: Vec<String>,
    lines: Vec<String>,
    has_times: bool,
}

impl Log {
    fn new(header: &[&str], lines: impl Iterator<Item = String>) -> Self {
        Self {
            header: header.iter().map(ToString::to_string).collect(),
            lines: lines.collect(),
            has_times: true,
        }
    }

    fn text(&self, look: Look) -> String {
        let mark = if look.mark { "\u{feff}" } else { "" };
        let lines = self.header.iter().chain(&self.lines);
        let lines: Vec<String> = lines
            .map(|line| format!("{line}{}", look.line_end))
            .collect();
        format!("{mark}{}", lines.concat())
    }
}

const EPOCH_S: u64 = 1_795_860_000;

/// Writes a conversation as a tool does.
type Writer = fn(&[Heard], Look) -> Log;

/// The writers, each from the description of its format.
const WRITERS: [(&str, Writer); 14] = [
    ("candump -L", candump_log),
    ("candump -t a, z or A", candump_screen),
    ("candump", candump_plain),
    ("candump -t d", candump_delta),
    ("ASC", asc),
    ("ASC with a CAN FD channel", asc_fd_channel),
    ("python-can CSV", python_csv),
    ("SavvyCAN CSV", gvret),
    ("python-can 3 text", printer_3),
    ("python-can 4 text", printer_4),
    ("TRC 1.0", trc_1_0),
    ("TRC 1.1", trc_1_1),
    ("TRC 1.3", trc_1_3),
    ("TRC 2.x", trc_2),
];

fn seconds(us: u64) -> String {
    format!("{}.{:06}", us / 1_000_000, us % 1_000_000)
}

fn candump_log(frames: &[Heard], look: Look) -> Log {
    let line = |heard: &Heard| {
        let data = match heard.remote {
            Some(0) => "R".to_owned(),
            Some(8) if look.pick.is_multiple_of(2) => "R8_C".to_owned(),
            Some(len) => format!("R{len}"),
            None if heard.data.len() == 8 && look.pick.is_multiple_of(3) => {
                format!("{}_9", heard.bytes(""))
            }
            None => heard.bytes(if look.pick.is_multiple_of(5) { "." } else { "" }),
        };
        let behind = ["", " R", " T"][look.pick % 3];
        format!(
            "({EPOCH_S}.{:06}) can0 {}#{data}{behind}",
            heard.at_us,
            heard.candump_id()
        )
    };
    Log::new(&[], frames.iter().map(line))
}

/// The part of a screen line behind the time.
fn screen(heard: &Heard, look: Look) -> String {
    let (on, off) = if look.colour {
        ("\u{1b}[1m\u{1b}[34m", "\u{1b}[0m")
    } else {
        ("", "")
    };
    let flags = ["", "  RX - -", "  TX - -"][look.pick % 3];
    let brackets = if look.pick.is_multiple_of(2) {
        ['[', ']']
    } else {
        ['{', '}']
    };
    let data = match heard.remote {
        Some(_) => " remote request".to_owned(),
        None if heard.data.is_empty() => " ".to_owned(),
        None => match look.pick % 4 {
            0 => {
                let bits: Vec<String> = heard
                    .data
                    .iter()
                    .map(|byte| format!("{byte:08b}"))
                    .collect();
                format!(" {}", bits.join(" "))
            }
            1 if heard.data.len() > 1 => {
                let mut swapped: Vec<String> = heard
                    .data
                    .iter()
                    .map(|byte| format!("{byte:02X}"))
                    .collect();
                swapped.reverse();
                format!(" {}", swapped.join("`"))
            }
            2 => format!(" {}   '{}'", heard.bytes(" "), ".".repeat(heard.data.len())),
            _ => format!(" {}", heard.bytes(" ")),
        },
    };
    format!(
        "{on}can0{flags}{off}  {}   {}{}{} {data}",
        heard.candump_id(),
        brackets[0],
        heard.len(),
        brackets[1]
    )
}

fn candump_screen(frames: &[Heard], look: Look) -> Log {
    let line = |heard: &Heard| {
        let time = match look.pick % 3 {
            0 => format!("{EPOCH_S}.{:06}", heard.at_us),
            1 => format!(
                "{:03}.{:06}",
                heard.at_us / 1_000_000,
                heard.at_us % 1_000_000
            ),
            _ => format!("2026-11-28 10:00:00.{:06}", heard.at_us),
        };
        format!(" ({time})  {}", screen(heard, look))
    };
    Log::new(&[], frames.iter().map(line))
}

fn candump_plain(frames: &[Heard], look: Look) -> Log {
    let lines = frames
        .iter()
        .map(|heard| format!("  {}", screen(heard, look)));
    Log {
        has_times: false,
        ..Log::new(&[], lines)
    }
}

fn candump_delta(frames: &[Heard], look: Look) -> Log {
    let mut before = frames[0].at_us;
    let line = |heard: &Heard| {
        let step = heard.at_us - core::mem::replace(&mut before, heard.at_us);
        format!(" (000.{step:06})  {}", screen(heard, look))
    };
    Log::new(&[], frames.iter().map(line))
}

fn asc(frames: &[Heard], look: Look) -> Log {
    let (base, radix) = if look.pick.is_multiple_of(2) {
        ("hex", 16)
    } else {
        ("dec", 10)
    };
    let relative = look.pick.is_multiple_of(3);
    let stamps = if relative { "relative" } else { "absolute" };
    let mut before = 0;
    let blanks = look.blanks;
    let line = |heard: &Heard| {
        let since = if relative { before } else { 0 };
        let time = seconds(heard.at_us - since);
        before = heard.at_us;
        let bytes: Vec<String> = heard
            .data
            .iter()
            .map(|byte| {
                if radix == 16 {
                    format!("{byte:02X}")
                } else {
                    byte.to_string()
                }
            })
            .collect();
        let kind = match heard.remote {
            Some(0) => "r".to_owned(),
            Some(len) => format!("r {len}"),
            None => format!("d {} {}", bytes.len(), bytes.join(" ")),
        };
        let behind = if look.pick.is_multiple_of(5) {
            "  Length = 244016 BitCount = 125 ID = 41"
        } else {
            ""
        };
        format!(
            "{blanks}{time} 1{blanks}{}{blanks}Rx{blanks}{kind}{behind}",
            heard.asc_id(radix)
        )
    };
    let base = format!("base {base}  timestamps {stamps}");
    Log::new(
        &[
            "date Sat Nov 28 10:00:00.000 am 2026",
            &base,
            "internal events logged",
            "// version 9.0.0",
        ],
        frames.iter().map(line),
    )
}

fn asc_fd_channel(frames: &[Heard], look: Look) -> Log {
    let blanks = look.blanks;
    let name = ["", "Status"][look.pick % 2];
    let line = |heard: &Heard| {
        let (len, flags, bytes) = match heard.remote {
            Some(_) => (0, "200050", String::new()),
            None => (heard.data.len(), "200000", heard.bytes(" ")),
        };
        format!(
            "{blanks}{} CANFD{blanks}1 Tx{blanks}{}{blanks}{name}{blanks}0 0 {} {len} {bytes} 242136 60 {flags} dbc 46500250",
            seconds(heard.at_us),
            heard.asc_id(16),
            heard.len()
        )
    };
    Log::new(
        &[
            "date Sat Nov 28 10:00:00.000 am 2026",
            "base hex  timestamps absolute",
        ],
        frames.iter().map(line),
    )
}

/// Comma separated columns in an order of their own.
fn columns(names: &[&str], rows: Vec<Vec<String>>, look: Look) -> Log {
    let mut order: Vec<usize> = (0..names.len()).collect();
    if look.pick.is_multiple_of(2) {
        order.rotate_left(look.pick / 2 % names.len());
    }
    let ordered = |cells: &[String]| {
        let cells: Vec<&str> = order
            .iter()
            .map(|index| cells.get(*index).map_or("", String::as_str))
            .collect();
        cells.join(",")
    };
    let header: Vec<String> = names.iter().map(ToString::to_string).collect();
    Log::new(&[&ordered(&header)], rows.iter().map(|row| ordered(row)))
}

fn python_csv(frames: &[Heard], look: Look) -> Log {
    let flag = |is_set: bool| u8::from(is_set).to_string();
    let row = |heard: &Heard| {
        vec![
            format!("{EPOCH_S}.{:06}", heard.at_us),
            format!("{:#x}", heard.id),
            flag(heard.extended),
            flag(heard.remote.is_some()),
            flag(false),
            heard.len().to_string(),
            STANDARD.encode(&heard.data),
        ]
    };
    columns(
        &[
            "timestamp",
            "arbitration_id",
            "extended",
            "remote",
            "error",
            "dlc",
            "data",
        ],
        frames.iter().map(row).collect(),
        look,
    )
}

/// SavvyCAN does not write remote frames: their bytes are zero.
fn gvret(frames: &[Heard], look: Look) -> Log {
    let names = [
        "Time Stamp",
        "ID",
        "Extended",
        "Bus",
        "LEN",
        "D1",
        "D2",
        "D3",
        "D4",
        "D5",
        "D6",
        "D7",
        "D8",
        "Dir",
    ];
    let row = |heard: &Heard| {
        let mut cells = vec![
            heard.at_us.to_string(),
            format!("{:08X}", heard.id),
            heard.extended.to_string(),
            "0".to_owned(),
            heard.data.len().to_string(),
        ];
        cells.extend((0..8).map(|place| {
            heard
                .data
                .get(place)
                .map_or("00".to_owned(), |byte| format!("{byte:02X}"))
        }));
        cells.push("Rx".to_owned());
        cells
    };
    columns(&names, frames.iter().map(row).collect(), look)
}

fn printer(frames: &[Heard], direction: &str, length: &str, digits: usize) -> Log {
    let line = |heard: &Heard| {
        let id = if heard.extended {
            format!("{:08x}", heard.id)
        } else {
            format!("{:0digits$x}", heard.id)
        };
        let kind = if heard.extended { "X" } else { "S" };
        let remote = if heard.remote.is_some() { "R" } else { " " };
        format!(
            "Timestamp: {:>15}    ID: {id}    {kind} {direction}   {remote}            {length} {:2}    {:24}    Channel: can0",
            seconds(heard.at_us),
            heard.len(),
            heard.bytes(" ").to_lowercase()
        )
    };
    Log::new(&[], frames.iter().map(line))
}

fn printer_3(frames: &[Heard], _: Look) -> Log {
    printer(frames, "", "DLC:", 4)
}

fn printer_4(frames: &[Heard], look: Look) -> Log {
    printer(frames, ["Rx", "Tx"][look.pick % 2], "DL:", 3)
}

/// The data column of the old versions.
fn trc_data(heard: &Heard) -> String {
    if heard.remote.is_some() {
        "RTR".to_owned()
    } else {
        heard.bytes(" ")
    }
}

fn milliseconds(us: u64) -> String {
    format!("{}.{:03}", us / 1_000, us % 1_000)
}

fn trc_old(
    version: Option<&str>,
    frames: &[Heard],
    look: Look,
    middle: fn(&Heard, &str) -> String,
) -> Log {
    let blanks = look.blanks;
    let version = version.map_or(";".to_owned(), |version| format!(";$FILEVERSION={version}"));
    let lines = frames.iter().zip(1..).map(|(heard, number)| {
        format!(
            "{blanks}{number}){blanks}{}{blanks}{}",
            milliseconds(heard.at_us),
            middle(heard, blanks)
        )
    });
    Log::new(
        &[&version, ";$STARTTIME=46062.4", ";   C:\\Prüfstand.trc"],
        lines,
    )
}

fn trc_1_0(frames: &[Heard], look: Look) -> Log {
    trc_old(None, frames, look, |heard, blanks| {
        format!(
            "{}{blanks}{} {}",
            heard.trc_id(),
            heard.len(),
            trc_data(heard)
        )
    })
}

fn trc_1_1(frames: &[Heard], look: Look) -> Log {
    trc_old(Some("1.1"), frames, look, |heard, blanks| {
        format!(
            "Tx{blanks}{}{blanks}{} {}",
            heard.trc_id(),
            heard.len(),
            trc_data(heard)
        )
    })
}

fn trc_1_3(frames: &[Heard], look: Look) -> Log {
    trc_old(Some("1.3"), frames, look, |heard, blanks| {
        format!(
            "1 Rx{blanks}{} -{blanks}{} {}",
            heard.trc_id(),
            heard.len(),
            trc_data(heard)
        )
    })
}

fn trc_2(frames: &[Heard], look: Look) -> Log {
    const ORDERS: [(&str, &str); 5] = [
        ("2.1", "N,O,T,B,I,d,R,L,D"),
        ("2.0", "N,O,T,I,d,l,D"),
        ("2.1", "N,O,T,B,I,d,L,D"),
        ("2.1", "O,T,B,I,l,D"),
        ("2.1", "B,I,d,T,O,N,L,D"),
    ];
    let (version, order) = ORDERS[look.pick % ORDERS.len()];
    let lines = frames.iter().zip(1..).map(|(heard, number)| {
        let cells = order.split(',').map(|column| match column {
            "N" => format!("{number}"),
            "O" => milliseconds(heard.at_us),
            "T" => if heard.remote.is_some() { "RR" } else { "DT" }.to_owned(),
            "B" => "1".to_owned(),
            "I" => heard.trc_id(),
            "d" => "Rx".to_owned(),
            "R" => "-".to_owned(),
            "D" => heard.bytes(" "),
            _ => heard.len().to_string(),
        });
        cells.collect::<Vec<_>>().join(look.blanks)
    });
    Log::new(
        &[
            &format!(";$FILEVERSION={version}"),
            ";$STARTTIME=46062.4",
            &format!(";$COLUMNS={order}"),
        ],
        lines,
    )
}

/// Frames with their times.
type Read = Vec<(Option<u64>, Frame)>;

/// The frames of a log with their times, or the number of the line that cannot be read.
fn read(text: &str) -> Result<Read, (usize, String)> {
    let mut reader = LogReader::new();
    reader.look_ahead(text.lines());
    let mut frames = Vec::new();
    for (index, line) in text.split('\n').enumerate() {
        match reader.line(line) {
            Ok(Some(entry)) => {
                let Event::Frame(frame) = entry.event else {
                    return Err((index + 1, format!("{:?}", entry.event)));
                };
                frames.push((entry.at_ns, frame));
            }
            Ok(None) => {}
            Err(error) => return Err((index + 1, error.to_string())),
        }
    }
    Ok(frames)
}

/// Times from the first frame on: every format has its own beginning.
fn from_first(frames: &[(Option<u64>, Frame)]) -> Read {
    let first = frames.first().and_then(|(at_ns, _)| *at_ns).unwrap_or(0);
    frames
        .iter()
        .map(|(at_ns, frame)| (at_ns.map(|at| at - first), *frame))
        .collect()
}

/// What must be read. Differences that never fall by half look like times from the first frame.
fn expected(name: &str, frames: &[Heard], log: &Log) -> Read {
    let mut times: Vec<u64> = frames
        .iter()
        .map(|heard| heard.at_us - frames[0].at_us)
        .collect();
    if name == "candump -t d" {
        let steps = core::iter::once(0).chain(times.windows(2).map(|pair| pair[1] - pair[0]));
        let steps: Vec<u64> = steps.collect();
        let mut most = 0;
        let falls = steps.windows(2).any(|pair| {
            most = most.max(pair[0]);
            pair[1] < pair[0] && pair[1] < most / 2
        });
        if !falls {
            times = steps;
        }
    }
    let frame = |(heard, at_us): (&Heard, u64)| {
        let is_gvret = name == "SavvyCAN CSV" && heard.remote.is_some();
        let frame = if is_gvret {
            Frame::new(heard.id, heard.extended, &[]).expect("a frame")
        } else {
            heard.frame()
        };
        (log.has_times.then_some(at_us * 1_000), frame)
    };
    frames.iter().zip(times).map(frame).collect()
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(100))]

    #[test]
    fn every_tool_writes_the_same_conversation(frames in frames(), look in looks()) {
        for (name, write) in WRITERS {
            let log = write(&frames, look);
            let text = log.text(look);
            let read = read(&text);
            prop_assert!(read.is_ok(), "{}: {:?} in {}", name, read, text);
            let read = from_first(&read.unwrap_or_default());
            let expected = expected(name, &frames, &log);
            prop_assert_eq!(read, expected, "{} in {}", name, text);
        }
    }

    #[test]
    fn a_damaged_line_is_refused_in_its_place(frames in frames(), look in looks(), place in any::<usize>(), how in 0_usize..4) {
        for (name, write) in WRITERS {
            let mut log = write(&frames, look);
            let place = place % log.lines.len();
            let line = &mut log.lines[place];
            match how {
                0 => *line = line.chars().take(line.chars().count().min(7)).collect(),
                1 => "garbage".clone_into(line),
                2 => *line = format!("?{line}"),
                _ => *line = line.replace(|letter: char| letter.is_ascii_digit(), "?"),
            }
            let text = log.text(look);
            let line = log.header.len() + place + 1;
            match read(&text) {
                Err((actual, message)) => {
                    prop_assert_eq!(actual, line, "{}: {} in {}", name, message, text);
                    prop_assert!(message.contains("expected"), "{}: {}", name, message);
                }
                Ok(read) => prop_assert!(false, "{}: {:?} in {}", name, read, text),
            }
        }
    }

    #[test]
    fn unknown_columns_are_refused_in_the_header(frames in frames(), look in looks(), letter in select(&["X", "o", "NN", "", "Data"][..])) {
        let log = trc_2(&frames, look);
        let text = log.text(look).replace("$COLUMNS=", &format!("$COLUMNS={letter},"));
        prop_assert!(matches!(read(&text), Err((3, message)) if message.contains("expected the columns")));
        for (write, name) in [(python_csv as Writer, "arbitration_id"), (gvret, "Extended")] {
            let text = write(&frames, look).text(look).replacen(name, "Unknown", 1);
            prop_assert!(matches!(read(&text), Err((1, message)) if message.contains("expected a log of")));
        }
    }
}
