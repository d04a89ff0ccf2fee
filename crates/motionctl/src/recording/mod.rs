//! What a motion leaves behind: every cycle, every frame, every event, for a page, a table, a log, an MCAP file or a view.
//!
//! Simulations and real motions feed the same [`Recorder`]. A simulation writes at once, because its time waits. A motion on a real
//! bus hands everything to a thread for each file through a queue of limited length: a full disk, a slow one or a reader that has
//! gone ends the recording and never delays the motion, and what was lost is counted.

mod about;
mod candump;
mod csv;
mod describe;
mod event;
mod frames;
mod intervals;
mod item;
mod keep;
mod keeper;
mod mcap;
mod model;
mod options;
mod outcome;
mod output_file;
mod queue;
mod recorder;
mod sample;
mod wheel_table;
mod wheel_words;
mod wire_frame;
mod words;

pub(crate) use about::{About, AxisAbout, AxisNaming, COUNTS_PER_RPM, Origin, Quantity};
pub(crate) use candump::candump_line;
pub(crate) use event::{Happening, Kind};
pub(crate) use frames::Sighting;
pub(crate) use item::Item;
pub(crate) use model::Recording;
pub(crate) use options::{RecordingError, RecordingOptions};
pub(crate) use outcome::{AxisOutcome, Outcome};
pub(crate) use queue::Viewer;
pub(crate) use recorder::{Recorded, Recorder, RecordingReport, WithRecording};
pub(crate) use sample::{AxisSample, Sample, WheelReadings};
pub(crate) use wheel_words::wheel_words;
pub(crate) use wire_frame::WireFrame;
pub(crate) use words::servo_words;
