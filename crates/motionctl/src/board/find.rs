//! `motionctl board find`: one question to each port.

use std::process::ExitCode;
use std::time::{Duration, Instant};

use board_link::frame::{Decoder, LONGEST_FRAME, Loss, VERSION, decode, encode};
use board_link::message::{Answer, Info, Reason, Request, ToBoard, ToHost};
use schemars::JsonSchema;
use serde::Serialize;
use serialport::SerialPortType;

use super::arguments::BAUD;
use super::error::BoardError;
use super::session::is_patience;
use crate::counted::counted;
use crate::exit;
use crate::link::BytePort;
use crate::output::{print, print_json, tell};

const EXAMPLES: &str = "\
Examples:
  motionctl board find
  motionctl board find --port tcp:7002 --json
  motionctl board find --all

Each port gets the same short question, which no drive on a serial line takes for a packet. Ports of USB devices are asked; with --all each
serial port of this computer, whatever is behind it. Ports in use are left alone.

Exit status: 0 a board answered, 1 none did.";

/// Time for an answer.
const ANSWER_TIME: Duration = Duration::from_millis(400);
/// With this number no byte of the question is one of a packet of a drive: see the test.
const NUMBER: u16 = 4;

/// Options of `motionctl board find`.
#[derive(Debug, clap::Args)]
#[command(after_help = EXAMPLES)]
pub(super) struct Arguments {
    /// Ask this port, too, or tcp:PORT of this machine; may be given several times.
    #[arg(long = "port", value_name = "TTY|tcp:PORT")]
    ports: Vec<String>,
    /// Ask each serial port, not only those on USB.
    #[arg(long)]
    all: bool,
    /// Speed of the serial ports in baud; USB CDC ignores it.
    #[arg(long, value_name = "BAUD", default_value_t = BAUD, value_parser = clap::value_parser!(u32).range(300..=12_000_000))]
    baud: u32,
    /// Print what was found as JSON.
    #[arg(long)]
    json: bool,
}

/// A port with a board.
#[derive(Debug, Serialize, JsonSchema)]
struct Found {
    port: String,
    board: String,
    firmware: String,
    axes: u8,
    /// Why it cannot be used with this version.
    #[serde(skip_serializing_if = "Option::is_none")]
    refusal: Option<String>,
}

#[derive(Debug, Serialize, JsonSchema)]
struct Report {
    boards: Vec<Found>,
    /// Ports that were asked.
    asked: Vec<String>,
}

/// Asks the ports, all at the same time.
pub(super) fn run(arguments: &Arguments) -> Result<ExitCode, BoardError> {
    let ports = ports(arguments);
    let boards: Vec<Found> = std::thread::scope(|scope| {
        let ask = |port: &String| {
            let port = port.clone();
            scope.spawn(move || ask(&port, arguments.baud))
        };
        let asked: Vec<_> = ports.iter().map(ask).collect();
        asked
            .into_iter()
            .filter_map(|thread| thread.join().ok().flatten())
            .collect()
    });
    let is_found = !boards.is_empty();
    let report = Report {
        boards,
        asked: ports,
    };
    if arguments.json {
        print_json(&report).map_err(BoardError::Print)?;
    } else {
        show(&report)?;
    }
    Ok(if is_found {
        ExitCode::SUCCESS
    } else {
        exit::BROKEN_PROMISE.into()
    })
}

fn ports(arguments: &Arguments) -> Vec<String> {
    let there = serialport::available_ports().unwrap_or_default();
    let there = there
        .into_iter()
        .filter(|port| is_meant(&port.port_type, arguments.all))
        .map(|port| port.port_name);
    let mut ports: Vec<String> = arguments.ports.iter().cloned().chain(there).collect();
    let mut seen = std::collections::BTreeSet::new();
    ports.retain(|port| seen.insert(port.clone()));
    ports
}

/// A board on USB may have any vendor and product, and so may the probe or cable of one with a UART.
const fn is_meant(kind: &SerialPortType, all: bool) -> bool {
    all || matches!(kind, SerialPortType::UsbPort(_))
}

fn show(report: &Report) -> Result<(), BoardError> {
    for found in &report.boards {
        let text = match &found.refusal {
            Some(refusal) => format!("{}: {refusal}", found.port),
            None => format!(
                "{}: {}, firmware {}, {}",
                found.port,
                found.board,
                found.firmware,
                match found.axes {
                    0 => "no settings".to_owned(),
                    axes => counted(axes, "axis", "axes").to_string(),
                }
            ),
        };
        print(text).map_err(BoardError::Print)?;
    }
    if report.boards.is_empty() {
        let asked = match report.asked.as_slice() {
            [] => {
                "no port is there to be asked; --all asks ports that are not on USB, too".to_owned()
            }
            asked => format!(
                "no board answers at {}: check cable, power and --baud",
                asked.join(", ")
            ),
        };
        tell(asked);
    }
    Ok(())
}

/// The question: the end of whatever came before, and Hello.
fn question() -> Vec<u8> {
    let message = ToBoard {
        number: NUMBER,
        session: 0,
        request: Request::Hello,
    };
    let mut frame = [0; LONGEST_FRAME];
    let length = encode(&message, &mut frame).unwrap_or_default();
    let mut bytes = vec![0];
    bytes.extend_from_slice(frame.get(..length).unwrap_or_default());
    bytes
}

fn ask(port: &str, baud: u32) -> Option<Found> {
    let mut open = BytePort::open(port, baud).ok()?;
    open.write_all_within(&question(), ANSWER_TIME).ok()?;
    let (until, mut decoder) = (Instant::now() + ANSWER_TIME, Decoder::new());
    let mut buffer = [0; 1_024];
    while Instant::now() < until {
        let left = until.saturating_duration_since(Instant::now());
        let length = match open.read_within(&mut buffer, left) {
            Ok(0) => return None,
            Ok(length) => length,
            Err(error) if is_patience(error.kind()) => continue,
            Err(_) => return None,
        };
        for &byte in buffer.get(..length).unwrap_or_default() {
            let found = match decoder.push(byte) {
                Some(Ok(content)) => decode::<ToHost>(content.body).and_then(answer),
                Some(Err(Loss::Version { actual })) => {
                    Some(Err(Reason::Version.because(VERSION.into(), actual.into())))
                }
                Some(Err(_)) | None => None,
            };
            if let Some(found) = found {
                return Some(of(port, found));
            }
        }
    }
    None
}

type Told = Result<Info, board_link::message::Refused>;

fn answer(message: ToHost) -> Option<Told> {
    match message {
        ToHost::Reply {
            number: NUMBER,
            result: Ok(Answer::Info(info)),
        } => Some(Ok(info)),
        ToHost::Reply {
            result: Err(refused),
            ..
        } => Some(Err(refused)),
        _ => None,
    }
}

fn of(port: &str, told: Told) -> Found {
    let info = told.as_ref().cloned().unwrap_or_default();
    Found {
        port: port.to_owned(),
        board: info.board.to_string(),
        firmware: info.firmware.to_string(),
        axes: info.axes,
        refusal: told.err().map(|refused| refused.to_string()),
    }
}

/// The shape of what `--json` prints.
pub(super) fn schema() -> schemars::Schema {
    crate::schema::of::<Report>()
}

#[cfg(test)]
mod tests {
    use serialport::UsbPortInfo;

    use super::*;

    #[test]
    fn a_port_on_usb_is_asked_whatever_its_vendor_and_product() {
        let on_usb = |vid, pid| {
            SerialPortType::UsbPort(UsbPortInfo {
                vid,
                pid,
                serial_number: None,
                manufacturer: None,
                product: None,
            })
        };
        // The board itself, the probe of a Nucleo, a cable.
        for (vid, pid) in [(0x1209, 0x0001), (0x0483, 0x374E), (0x0403, 0x6001)] {
            assert!(is_meant(&on_usb(vid, pid), false));
        }
        for kind in [SerialPortType::PciPort, SerialPortType::Unknown] {
            assert!(!is_meant(&kind, false));
            assert!(is_meant(&kind, true));
        }
    }

    /// A packet of a drive is a byte below 80h and at least three from 80h on (DYN serial protocol, section 4).
    #[test]
    fn no_drive_takes_the_question_for_a_packet() {
        let question = question();
        let longest = question
            .split(|byte| *byte < 0x80)
            .map(<[u8]>::len)
            .max()
            .unwrap_or_default();
        assert!(longest < 3, "{question:02X?}");
    }
}
