//! The run as an MCAP file, which Foxglove and PlotJuggler open: messages in JSON on channels with a JSON schema.
//!
//! | Topic | One message for each |
//! |---|---|
//! | `/cycle` | cycle: number, time, load of the bus |
//! | `/axis/NAME` | cycle, of one axis: set-point, position, following error, state; of a wheel speeds |
//! | `/frames` | frame, as on the wire and in words |
//! | `/events` | event |
//!
//! A value that is not known in a cycle is left out of its message.

use std::collections::{BTreeMap, BTreeSet};
use std::io::{self, Write};

use mcap::records::{MessageHeader, Metadata};
use mcap::write::NoSeek;
use mcap::{McapError, WriteOptions, Writer};
use serde::Serialize;

use super::about::{About, AxisAbout, AxisNaming, Quantity};
use super::describe::{Describer, Description};
use super::event::Happening;
use super::item::Item;
use super::keep::Keep;
use super::sample::{AxisSample, Sample};
use super::wire_frame::WireFrame;

mod schema;

/// An MCAP file in the making.
pub(super) struct McapFile<W: Write> {
    /// Without seeking, so that a pipe takes it too.
    writer: Writer<NoSeek<W>>,
    channels: Channels,
    axes: Vec<AxisAbout>,
    quantity: Quantity,
    describer: Describer,
    started_unix_ns: u64,
    /// Counts of the axes at the start of the motion.
    start_counts: Option<Vec<i32>>,
    sequence: BTreeMap<u16, u32>,
    json: Vec<u8>,
}

struct Channels {
    cycle: u16,
    axes: Vec<u16>,
    frames: u16,
    events: u16,
}

#[derive(Serialize)]
struct CycleMessage {
    time_s: f64,
    number: u64,
    bus_load: f64,
    late: bool,
}

#[derive(Serialize)]
struct AxisMessage {
    time_s: f64,
    #[serde(skip_serializing_if = "Option::is_none")]
    state: Option<String>,
    target: f64,
    sent: f64,
    #[serde(skip_serializing_if = "Option::is_none")]
    position: Option<f64>,
    #[serde(skip_serializing_if = "Option::is_none")]
    following_error: Option<f64>,
    target_counts: i32,
    sent_counts: i32,
    #[serde(skip_serializing_if = "Option::is_none")]
    position_counts: Option<i64>,
    #[serde(skip_serializing_if = "Option::is_none")]
    following_error_counts: Option<i64>,
    backlog_counts: i32,
    #[serde(skip_serializing_if = "Option::is_none")]
    status_age_ms: Option<f64>,
    #[serde(skip_serializing_if = "Option::is_none")]
    position_age_ms: Option<f64>,
}

#[derive(Serialize)]
struct WheelMessage {
    time_s: f64,
    #[serde(skip_serializing_if = "Option::is_none")]
    state: Option<String>,
    target: f64,
    sent: f64,
    #[serde(skip_serializing_if = "Option::is_none")]
    speed: Option<f64>,
    #[serde(skip_serializing_if = "Option::is_none")]
    speed_error: Option<f64>,
    #[serde(skip_serializing_if = "Option::is_none")]
    status_age_ms: Option<f64>,
    #[serde(skip_serializing_if = "Option::is_none")]
    position_age_ms: Option<f64>,
}

#[derive(Serialize)]
struct FrameMessage<'a> {
    time_s: f64,
    id: u32,
    extended: bool,
    remote: bool,
    /// Two hexadecimal digits a byte.
    data: String,
    #[serde(skip_serializing_if = "Option::is_none")]
    from_master: Option<bool>,
    text: &'a str,
    #[serde(skip_serializing_if = "Option::is_none")]
    failure: Option<&'a str>,
}

#[derive(Serialize)]
struct EventMessage<'a> {
    time_s: f64,
    kind: &'a str,
    #[serde(skip_serializing_if = "Option::is_none")]
    axis: Option<&'a str>,
    #[serde(skip_serializing_if = "Option::is_none")]
    drive: Option<u8>,
    text: &'a str,
}

impl<W: Write> McapFile<W> {
    /// A file with its channels.
    pub(super) fn new(to: W, about: &About) -> io::Result<Self> {
        let mut writer = WriteOptions::new()
            .compression(Some(mcap::Compression::Zstd))
            // In the thread of the file alone.
            .compression_threads(0)
            .disable_seeking(true)
            .profile("")
            .library(format!("motionctl {}", About::version()))
            .create(NoSeek::new(to))
            .map_err(io_error)?;
        let channels = channels(&mut writer, about).map_err(io_error)?;
        let facts = about.facts().into_iter();
        let metadata = Metadata {
            name: "motionctl".to_owned(),
            metadata: facts.map(|(name, text)| (name.to_owned(), text)).collect(),
        };
        writer.write_metadata(&metadata).map_err(io_error)?;
        Ok(Self {
            writer,
            channels,
            axes: about.axes.clone(),
            quantity: about.quantity,
            describer: Describer::new(about.quantity),
            started_unix_ns: about.started_unix_ns,
            start_counts: None,
            sequence: BTreeMap::new(),
            json: Vec::new(),
        })
    }

    /// From here on the axes are on topics of these names.
    fn name_axes(&mut self, naming: &[AxisNaming]) -> io::Result<()> {
        for (axis, naming) in self.axes.iter_mut().zip(naming) {
            *axis = axis.clone().named(naming.clone());
        }
        let channels = axis_channels(&mut self.writer, &self.axes, self.quantity);
        self.channels.axes = channels.map_err(io_error)?;
        Ok(())
    }

    fn message(&mut self, channel: u16, at_ns: u64, message: &impl Serialize) -> io::Result<()> {
        self.json.clear();
        serde_json::to_writer(&mut self.json, message)?;
        let sequence = self.sequence.entry(channel).or_default();
        *sequence = sequence.wrapping_add(1);
        let time = self.started_unix_ns.saturating_add(at_ns);
        let header = MessageHeader {
            channel_id: channel,
            sequence: *sequence,
            log_time: time,
            publish_time: time,
        };
        self.writer
            .write_to_known_channel(&header, &self.json)
            .map_err(io_error)
    }

    fn cycle(&mut self, sample: &Sample) -> io::Result<()> {
        let at_ns = sample.at_us.saturating_mul(1_000);
        let time_s = sample.at_us as f64 * 1e-6;
        let cycle = CycleMessage {
            time_s,
            number: sample.number,
            bus_load: sample.load,
            late: sample.is_late,
        };
        self.message(self.channels.cycle, at_ns, &cycle)?;
        for (axis, values) in sample.axes.iter().enumerate() {
            let (Some(about), Some(&channel)) =
                (self.axes.get(axis).cloned(), self.channels.axes.get(axis))
            else {
                continue;
            };
            if self.quantity == Quantity::Speed {
                self.message(channel, at_ns, &wheel_message(time_s, &about, values))?;
                continue;
            }
            let start = self.start_counts.as_ref().and_then(|all| all.get(axis));
            let start = start.copied().unwrap_or(values.target);
            let message = axis_message(time_s, &about, values, start);
            self.message(channel, at_ns, &message)?;
        }
        Ok(())
    }

    fn frame(&mut self, frame: &WireFrame) -> io::Result<()> {
        let Description { text, .. } = self.describer.describe(frame);
        let message = FrameMessage {
            time_s: frame.end_ns as f64 * 1e-9,
            id: frame.frame.id(),
            extended: frame.frame.is_extended(),
            remote: frame.frame.is_remote(),
            data: hex(frame.frame.data()),
            from_master: frame.from_master,
            text: text.trim_end(),
            failure: frame.failure,
        };
        self.message(self.channels.frames, frame.end_ns, &message)
    }

    fn event(&mut self, event: &Happening) -> io::Result<()> {
        let about = event.axis.and_then(|axis| self.axes.get(axis)).cloned();
        let message = EventMessage {
            time_s: event.at_us as f64 * 1e-6,
            kind: event.kind.name(),
            axis: about.as_ref().map(|about| about.name.as_str()),
            drive: about.as_ref().map(|about| about.drive),
            text: &event.text,
        };
        self.message(
            self.channels.events,
            event.at_us.saturating_mul(1_000),
            &message,
        )
    }
}

impl<W: Write + Send> Keep for McapFile<W> {
    fn keep(&mut self, item: &Item) -> io::Result<()> {
        match item {
            Item::Cycle(sample) => {
                if self.start_counts.is_none() {
                    self.start_counts = Some(sample.axes.iter().map(|axis| axis.target).collect());
                }
                self.cycle(sample)
            }
            Item::Frame(frame) => self.frame(frame),
            Item::Event(event) => self.event(event),
            // The next cycle is the first of the motion: where its axes stand is the start of the file.
            Item::MotionBegins { .. } => Ok(()),
            Item::Naming(naming) => self.name_axes(naming),
        }
    }

    fn flush(&mut self) -> io::Result<()> {
        self.writer.flush().map_err(io_error)
    }

    fn finish(&mut self) -> io::Result<()> {
        self.writer.finish().map(drop).map_err(io_error)
    }
}

/// The values of an axis in its unit: the start of the motion is the first value of the file.
fn axis_message(
    time_s: f64,
    about: &AxisAbout,
    values: &AxisSample,
    start_counts: i32,
) -> AxisMessage {
    let value = |counts: i64| {
        about.start + (counts - i64::from(start_counts)) as f64 / about.counts_per_unit
    };
    let ms = |us: u32| f64::from(us) * 1e-3;
    AxisMessage {
        time_s,
        state: values.state.map(|state| state.to_string()),
        target: value(values.target.into()),
        sent: value(values.sent.into()),
        position: values.position.map(value),
        following_error: values
            .error()
            .map(|counts| counts as f64 / about.counts_per_unit),
        target_counts: values.target,
        sent_counts: values.sent,
        position_counts: values.position,
        following_error_counts: values.error(),
        backlog_counts: values.backlog,
        status_age_ms: values.status_age_us.map(ms),
        position_age_ms: values.position_age_us.map(ms),
    }
}

/// The speeds of a wheel in r/min.
fn wheel_message(time_s: f64, about: &AxisAbout, values: &AxisSample) -> WheelMessage {
    let value = |counts: i64| counts as f64 / about.counts_per_unit;
    let ms = |us: u32| f64::from(us) * 1e-3;
    WheelMessage {
        time_s,
        state: values.state.map(|state| state.to_string()),
        target: value(values.target.into()),
        sent: value(values.sent.into()),
        speed: values.position.map(value),
        speed_error: values.error().map(value),
        status_age_ms: values.status_age_us.map(ms),
        position_age_ms: values.position_age_us.map(ms),
    }
}

fn channels<W: Write + io::Seek>(
    writer: &mut Writer<W>,
    about: &About,
) -> Result<Channels, McapError> {
    let none = BTreeMap::new();
    Ok(Channels {
        cycle: add_channel(writer, &schema::CYCLE, "/cycle", &none)?,
        frames: add_channel(writer, &schema::FRAME, "/frames", &none)?,
        events: add_channel(writer, &schema::EVENT, "/events", &none)?,
        axes: axis_channels(writer, &about.axes, about.quantity)?,
    })
}

fn add_channel<W: Write + io::Seek>(
    writer: &mut Writer<W>,
    schema: &schema::Schema,
    topic: &str,
    metadata: &BTreeMap<String, String>,
) -> Result<u16, McapError> {
    let text = schema.text().to_string();
    let id = writer.add_schema(schema.name, "jsonschema", text.as_bytes())?;
    writer.add_channel(id, topic, "json", metadata)
}

fn axis_channels<W: Write + io::Seek>(
    writer: &mut Writer<W>,
    axes: &[AxisAbout],
    quantity: Quantity,
) -> Result<Vec<u16>, McapError> {
    let schema = match quantity {
        Quantity::Position => &schema::AXIS,
        Quantity::Speed => &schema::WHEEL,
    };
    let mut channels = Vec::new();
    for (axis, topic) in axes.iter().zip(topics(axes)) {
        let metadata = BTreeMap::from([
            ("unit".to_owned(), axis.unit.clone()),
            ("drive".to_owned(), axis.drive.to_string()),
            (
                "counts_per_unit".to_owned(),
                axis.counts_per_unit.to_string(),
            ),
        ]);
        channels.push(add_channel(writer, schema, &topic, &metadata)?);
    }
    Ok(channels)
}

/// `/axis/NAME`, with letters that every tool takes, and each once.
fn topics(axes: &[AxisAbout]) -> Vec<String> {
    let mut taken = BTreeSet::new();
    let topic = |axis: &AxisAbout| {
        let safe = |c: char| {
            if c.is_ascii_alphanumeric() || "_-.".contains(c) {
                c
            } else {
                '_'
            }
        };
        let name: String = axis.name.chars().map(safe).collect();
        let topic = format!("/axis/{name}");
        if !name.is_empty() && taken.insert(topic.clone()) {
            topic
        } else {
            // Every drive is in a motion once.
            format!("{topic}.drive{}", axis.drive)
        }
    };
    axes.iter().map(topic).collect()
}

fn hex(bytes: &[u8]) -> String {
    bytes.iter().map(|byte| format!("{byte:02X}")).collect()
}

fn io_error(error: McapError) -> io::Error {
    match error {
        McapError::Io(error) => error,
        other => io::Error::other(other),
    }
}

#[cfg(test)]
mod tests;
