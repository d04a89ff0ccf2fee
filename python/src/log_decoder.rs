//! Lines of a log, or frames, into what they say: the shape of the lines of `motionctl decode --json`.

use can_decode::dyn_drives::Settings;
use can_decode::log::{Entry, Event, LineError, LogReader, Stamps};
use can_decode::{Decoder, Frame, Meaning};
use dyn_can::Revision;
use pyo3::prelude::*;
use pyo3::types::PyDict;
use pythonize::pythonize;
use serde::{Serialize, Serializer};

use crate::errors::{codec_error, input_error};
use crate::values::Octets;

/// A frame and its meaning.
#[derive(Serialize)]
struct FrameLine<'a> {
    kind: &'static str,
    time_s: Option<f64>,
    interface: &'a str,
    id: u32,
    extended: bool,
    remote: bool,
    data: String,
    #[serde(serialize_with = "as_text")]
    text: &'a Meaning,
    #[serde(flatten)]
    meaning: &'a Meaning,
}

fn as_text<S: Serializer>(meaning: &Meaning, serializer: S) -> Result<S::Ok, S::Error> {
    serializer.collect_str(meaning)
}

/// How a bus is read.
#[derive(Clone, Copy)]
struct Protocol {
    is_canopen: bool,
    settings: Settings,
}

impl Protocol {
    fn of(py: Python<'_>, protocol: &str, revision: Option<&str>, reply_ms: f64) -> PyResult<Self> {
        let is_canopen = match protocol {
            "dyn" => false,
            "canopen" => true,
            other => {
                let text = format_args!("protocol: expected dyn or canopen, got {other}");
                return Err(input_error(py, text));
            }
        };
        let revision = match revision {
            None => None,
            Some("1.2A") => Some(Revision::V1_2A),
            Some("1.6A") => Some(Revision::V1_6A),
            Some(other) => {
                let text = format_args!("revision: expected 1.2A, 1.6A or None, got {other}");
                return Err(input_error(py, text));
            }
        };
        if !(0.0..=3_600_000.0).contains(&reply_ms) {
            let text = format_args!("reply_ms: expected 0 to 3600000, got {reply_ms}");
            return Err(input_error(py, text));
        }
        let settings = Settings {
            revision,
            reply_window_ns: (reply_ms * 1e6) as u64,
            ..Settings::DEFAULT
        };
        Ok(Self {
            is_canopen,
            settings,
        })
    }

    fn decoder(&self) -> Decoder {
        if self.is_canopen {
            Decoder::canopen()
        } else {
            Decoder::new(self.settings)
        }
    }
}

/// One interface of a log.
struct Bus {
    interface: String,
    decoder: Decoder,
    latest_ns: u64,
}

/// Reads a log line by line.
#[pyclass(module = "motion_board._native")]
pub(crate) struct LogDecoder {
    protocol: Protocol,
    reader: LogReader,
    buses: Vec<Bus>,
}

#[pymethods]
impl LogDecoder {
    #[new]
    fn new(
        py: Python<'_>,
        protocol: &str,
        revision: Option<&str>,
        reply_ms: f64,
        stamps: Option<&str>,
    ) -> PyResult<Self> {
        let reader = match stamps {
            None => LogReader::new(),
            Some("zero") => LogReader::with_stamps(Stamps::Zero),
            Some("delta") => LogReader::with_stamps(Stamps::Delta),
            Some(other) => {
                let text = format_args!("stamps: expected zero, delta or None, got {other}");
                return Err(input_error(py, text));
            }
        };
        Ok(Self {
            protocol: Protocol::of(py, protocol, revision, reply_ms)?,
            reader,
            buses: Vec::new(),
        })
    }

    /// Looks at lines that will be read later.
    fn look_ahead(&mut self, text: &str) {
        self.reader.look_ahead(text.lines());
    }

    /// What a line says: nothing, one dictionary, or two where the time goes back.
    fn line<'py>(&mut self, py: Python<'py>, line: &str) -> PyResult<Vec<Bound<'py, PyAny>>> {
        let mut said = Vec::new();
        match self.reader.line(line) {
            Ok(None) => {}
            Ok(Some(entry)) => {
                let bus = bus_of(&mut self.buses, entry.interface, &self.protocol);
                if let Some(at_ns) = entry.at_ns {
                    let before_ns = core::mem::replace(&mut bus.latest_ns, at_ns);
                    if at_ns < before_ns {
                        said.push(goes_back(py, before_ns, at_ns)?);
                    }
                }
                said.push(heard(py, bus, &entry)?);
            }
            Err(error) => said.push(damage(py, line, &error)?),
        }
        Ok(said)
    }
}

fn bus_of<'a>(buses: &'a mut Vec<Bus>, interface: &str, protocol: &Protocol) -> &'a mut Bus {
    let known = buses.iter().position(|bus| bus.interface == interface);
    let place = known.unwrap_or_else(|| {
        buses.push(Bus {
            interface: interface.to_owned(),
            decoder: protocol.decoder(),
            latest_ns: 0,
        });
        buses.len() - 1
    });
    &mut buses[place]
}

fn heard<'py>(py: Python<'py>, bus: &mut Bus, entry: &Entry<'_>) -> PyResult<Bound<'py, PyAny>> {
    let text = match &entry.event {
        Event::Frame(frame) => {
            let meaning = bus.decoder.hear(entry.at_ns, frame);
            return frame_line(py, entry.at_ns, entry.interface, frame, &meaning);
        }
        Event::ErrorFrame => "error frame: a node saw an error on the bus",
        Event::OverloadFrame => "overload frame: a node asked for a pause",
        Event::ControllerState => {
            "the controller told its state: see the log for warnings and bus off"
        }
        Event::FdFrame => "CAN FD frame: not for a classic bus",
        _ => "an event that is no frame",
    };
    let line = PyDict::new(py);
    line.set_item("kind", "other")?;
    line.set_item("time_s", entry.at_ns.map(seconds))?;
    line.set_item("interface", entry.interface)?;
    line.set_item("text", text)?;
    Ok(line.into_any())
}

fn frame_line<'py>(
    py: Python<'py>,
    at_ns: Option<u64>,
    interface: &str,
    frame: &Frame,
    meaning: &Meaning,
) -> PyResult<Bound<'py, PyAny>> {
    let line = FrameLine {
        kind: "frame",
        time_s: at_ns.map(seconds),
        interface,
        id: frame.id(),
        extended: frame.is_extended(),
        remote: frame.is_remote(),
        data: frame
            .data()
            .iter()
            .map(|byte| format!("{byte:02X}"))
            .collect(),
        text: meaning,
        meaning,
    };
    Ok(pythonize(py, &line)?)
}

fn damage<'py>(py: Python<'py>, line: &str, error: &LineError) -> PyResult<Bound<'py, PyAny>> {
    let said = PyDict::new(py);
    said.set_item("kind", "error")?;
    said.set_item("error", words_of(error))?;
    said.set_item("column", column_of(line, error))?;
    said.set_item("ends_log", error.ends_log())?;
    Ok(said.into_any())
}

/// What is an option of the tool is an argument here.
fn words_of(error: &LineError) -> String {
    let text = error.to_string();
    match error {
        LineError::Differences { .. } => text
            .replace("--stamps delta", "stamps=\"delta\"")
            .replace("--stamps zero", "stamps=\"zero\""),
        _ => text,
    }
}

/// Where the part stands that is wrong, in letters from 1; nothing where it is not there exactly once.
fn column_of(line: &str, error: &LineError) -> Option<usize> {
    let line = line.trim_end();
    let part = match error {
        LineError::Missing { .. } => return Some(line.chars().count() + 1),
        LineError::Field { actual, .. } | LineError::Header { actual, .. } => actual.as_str(),
        _ => return None,
    };
    let part = part.strip_suffix("...").unwrap_or(part);
    let mut places = line.match_indices(part);
    let (first, _) = places.next().filter(|_| !part.is_empty())?;
    places
        .next()
        .is_none()
        .then(|| line[..first].chars().count() + 1)
}

fn goes_back(py: Python<'_>, before_ns: u64, at_ns: u64) -> PyResult<Bound<'_, PyAny>> {
    let said = PyDict::new(py);
    let (before, at) = (seconds(before_ns), seconds(at_ns));
    said.set_item("kind", "error")?;
    said.set_item(
        "error",
        format!("time goes back from {before:.6} s to {at:.6} s: replies may be taken for others"),
    )?;
    said.set_item("column", None::<usize>)?;
    said.set_item("ends_log", false)?;
    Ok(said.into_any())
}

/// Reads frames one by one.
#[pyclass(module = "motion_board._native")]
pub(crate) struct FrameDecoder {
    decoder: Decoder,
}

#[pymethods]
impl FrameDecoder {
    #[new]
    fn new(
        py: Python<'_>,
        protocol: &str,
        revision: Option<&str>,
        reply_ms: f64,
    ) -> PyResult<Self> {
        let protocol = Protocol::of(py, protocol, revision, reply_ms)?;
        Ok(Self {
            decoder: protocol.decoder(),
        })
    }

    /// What a frame says.
    fn hear<'py>(
        &mut self,
        py: Python<'py>,
        id: u32,
        data: Octets,
        extended: bool,
        remote: bool,
        time_s: Option<f64>,
    ) -> PyResult<Bound<'py, PyAny>> {
        let frame = if remote {
            Frame::remote(id, extended, data.len() as u8)
        } else {
            Frame::new(id, extended, &data)
        };
        let Some(frame) = frame.filter(|_| data.len() <= 8) else {
            let length = data.len();
            let text = format_args!(
                "expected an identifier of 11 bits (29 in an extended frame) and at most 8 bytes, got 0x{id:X} and {length}"
            );
            return Err(codec_error(py, text));
        };
        let at_ns = match time_s {
            None => None,
            Some(time_s) if (0.0..1e10).contains(&time_s) => Some((time_s * 1e9) as u64),
            Some(time_s) => {
                let text = format_args!("time_s: expected 0 to 1e10 seconds, got {time_s}");
                return Err(input_error(py, text));
            }
        };
        let meaning = self.decoder.hear(at_ns, &frame);
        frame_line(py, at_ns, "", &frame, &meaning)
    }
}

fn seconds(ns: u64) -> f64 {
    ns as f64 / 1e9
}
