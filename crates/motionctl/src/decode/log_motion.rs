//! The motion in a log, recovered from its frames alone: set-points are summed, positions are read.
//!
//! A cycle of the log is a row of set-points in which no drive comes twice; a position belongs to the row before it. Where a drive
//! stood before its first set-point is the position that was read last before that one.

use std::collections::BTreeMap;

use can_decode::dyn_drives::{Content, Message, Note};
use can_decode::{Frame, Meaning};
use dyn_can::{Alarm, DriveId, Reply, Request, ServoSwitch};

use super::error::DecodeError;
use crate::counted::counted;
use crate::recording::{
    About, AxisAbout, AxisOutcome, AxisSample, Happening, Item, Kind, Origin, Outcome, Recording,
    Sample, WireFrame,
};

/// Seconds since 1970 that no log can have that counts from its own begin: 2001.
const SINCE_1970_NS: u64 = 1_000_000_000_000_000_000;

/// One drive.
#[derive(Debug, Default)]
struct Drive {
    /// Its place among the axes.
    axis: usize,
    /// Where its set-points take it.
    sent: i32,
    /// Whether it is known where it stood before them.
    is_anchored: bool,
    set_points: u64,
    /// The position that was read in this row, and the one that was read last.
    fresh: Option<i32>,
    read: Option<i32>,
    /// It has a set-point in this row.
    is_in_row: bool,
    alarm: Option<Alarm>,
}

/// The motion on one interface.
#[derive(Debug)]
pub(super) struct LogMotion {
    recording: Recording,
    drives: BTreeMap<u8, Drive>,
    start_ns: Option<u64>,
    /// End of the last set-point or reading of this row.
    row_end_ns: u64,
    row: u64,
    /// Least length of the frames since the last row.
    busy_ns: u64,
    sample_us: u64,
    repeated: u64,
}

impl LogMotion {
    pub(super) fn new(interface: &str, bit_ns: u64) -> Self {
        let about = About {
            interface: interface.to_owned(),
            started_unix_ns: 0,
            ..About::now(Origin::Log, Vec::new(), 0, bit_ns)
        };
        Self {
            recording: Recording::new(about),
            drives: BTreeMap::new(),
            start_ns: None,
            row_end_ns: 0,
            row: 0,
            busy_ns: 0,
            sample_us: 0,
            repeated: 0,
        }
    }

    /// A frame that ended at this time of the log.
    pub(super) fn frame(&mut self, at_ns: u64, frame: &Frame, meaning: &Meaning) {
        let at_ns = self.since_start(at_ns);
        if let Meaning::Dyn(message) = meaning {
            self.message(at_ns, message);
        }
        self.notice(at_ns, meaning);
        let frame = WireFrame::ended(at_ns, *frame, None, self.recording.about.bit_ns);
        self.busy_ns += u64::from(frame.bits) * self.recording.about.bit_ns;
        self.recording.add(&Item::Frame(frame));
    }

    pub(super) fn error_frame(&mut self, at_ns: u64) {
        let at_ns = self.since_start(at_ns);
        let text = "error frame: a node saw an error on the bus";
        self.happened(at_ns, None, Kind::Notice, text.to_owned());
    }

    /// The record of the whole log.
    ///
    /// # Errors
    /// When it has no times.
    pub(super) fn finish(mut self) -> Result<(Recording, Outcome), DecodeError> {
        if self.start_ns.is_none() {
            return Err(DecodeError::NoPage {
                reason: "it has no frames with times",
            });
        }
        self.end_row();
        self.recording.recognise_cycle();
        self.recording.even_out();
        let outcome = self.outcome();
        Ok((self.recording, outcome))
    }

    fn since_start(&mut self, at_ns: u64) -> u64 {
        let start_ns = *self.start_ns.get_or_insert(at_ns);
        if start_ns < SINCE_1970_NS {
            // The log has a start of its own.
            return at_ns;
        }
        self.recording.about.started_unix_ns = start_ns;
        // A log whose times go back says so where its lines are read.
        at_ns.saturating_sub(start_ns)
    }

    fn message(&mut self, at_ns: u64, message: &Message) {
        let Some(id) = message.address.drive() else {
            return;
        };
        match message.content {
            Content::Request(Request::GoRelativePosPd(step)) => {
                // It counts: who heard it twice is no other than a drive that did. And a master that catches up sends two equal
                // steps this soon, in the times of the computer that wrote the log.
                let is_repeated = matches!(message.note, Some(Note::Repeated { .. }));
                self.repeated += u64::from(is_repeated);
                if self.drive(id).is_in_row {
                    self.end_row();
                }
                if self.recording.motion_start.is_none() {
                    let (at_us, number) = (at_ns / 1_000, self.row);
                    self.recording.add(&Item::MotionBegins { at_us, number });
                    let text = "the first set-point".to_owned();
                    self.happened(at_ns, None, Kind::Phase, text);
                }
                let drive = self.drive(id);
                if !drive.is_anchored && drive.set_points == 0 {
                    drive.sent = drive.read.unwrap_or(0);
                    drive.is_anchored = drive.read.is_some();
                }
                drive.sent = drive.sent.wrapping_add(i32::from(step.get()));
                drive.set_points += 1;
                drive.is_in_row = true;
                self.row_end_ns = at_ns;
            }
            Content::Reply { reply, .. } => self.reply(at_ns, id, reply),
            Content::Request(Request::ServoDisable(switch)) => {
                let text = match switch {
                    ServoSwitch::Enable => "told to switch on",
                    ServoSwitch::Disable => "told to switch off",
                };
                let axis = self.drive(id).axis;
                self.happened(at_ns, Some(axis), Kind::State, text.to_owned());
            }
            _ => {}
        }
    }

    fn reply(&mut self, at_ns: u64, id: DriveId, reply: Reply) {
        match reply {
            Reply::Position(counts) => self.position(at_ns, id, counts),
            Reply::DriveStatus(status) => {
                let alarm = status.alarm();
                let drive = self.drive(id);
                let (axis, before) = (drive.axis, drive.alarm.replace(alarm));
                if before != Some(alarm) && alarm.is_alarm() {
                    let text = format!("the status shows an alarm: {alarm}");
                    self.happened(at_ns, Some(axis), Kind::Fault, text);
                }
            }
            Reply::DriveError(error) => {
                let axis = self.drive(id).axis;
                let text = format!("the drive reports {error}");
                self.happened(at_ns, Some(axis), Kind::Fault, text);
            }
            _ => {}
        }
    }

    fn position(&mut self, at_ns: u64, id: DriveId, counts: i32) {
        // Positions alone make rows too, as when a monitor reads them.
        if self.drive(id).fresh.is_some() {
            self.end_row();
        }
        let drive = self.drive(id);
        let (axis, shift) = (drive.axis, counts.wrapping_sub(drive.sent));
        (drive.fresh, drive.read) = (Some(counts), Some(counts));
        if drive.set_points == 0 {
            drive.sent = counts;
        } else if !drive.is_anchored {
            // Its set-points are moved to where it was seen first.
            drive.sent = counts;
            drive.is_anchored = true;
            self.recording.shift(axis, shift);
        }
        self.row_end_ns = self.row_end_ns.max(at_ns);
    }

    fn drive(&mut self, id: DriveId) -> &mut Drive {
        let recording = &mut self.recording;
        self.drives.entry(id.get()).or_insert_with(|| {
            recording.add_axis(AxisAbout::of_drive(id));
            Drive {
                axis: recording.about.axes.len() - 1,
                ..Drive::default()
            }
        })
    }

    /// A row of set-points is complete.
    fn end_row(&mut self) {
        let mut by_axis: Vec<(usize, AxisSample)> = self
            .drives
            .values_mut()
            .map(|drive| {
                drive.is_in_row = false;
                let sample = AxisSample {
                    target: drive.sent,
                    sent: drive.sent,
                    position: drive.fresh.take().map(i64::from),
                    backlog: 0,
                    status_age_us: None,
                    position_age_us: None,
                    state: None,
                };
                (drive.axis, sample)
            })
            .collect();
        if by_axis.is_empty() {
            return;
        }
        by_axis.sort_by_key(|(axis, _)| *axis);
        let at_us = self.row_end_ns / 1_000;
        let passed_ns = at_us.saturating_sub(self.sample_us) * 1_000;
        self.recording.add(&Item::Cycle(Sample {
            at_us,
            number: self.row,
            load: (self.busy_ns as f64 / passed_ns.max(1) as f64).min(1.0),
            is_late: false,
            axes: by_axis.into_iter().map(|(_, sample)| sample).collect(),
            wheels: Vec::new(),
        }));
        self.row += 1;
        (self.busy_ns, self.sample_us) = (0, at_us);
    }

    /// What looks like trouble, but for what is an event of its own.
    fn notice(&mut self, at_ns: u64, meaning: &Meaning) {
        let is_alarm = matches!(
            meaning,
            Meaning::Dyn(Message {
                content: Content::Reply {
                    reply: Reply::DriveError(_),
                    ..
                },
                note: None,
                ..
            })
        );
        if meaning.is_remarkable() && !is_alarm {
            let drive = meaning.drive().and_then(|drive| self.drives.get(&drive));
            let axis = drive.map(|drive| drive.axis);
            self.happened(at_ns, axis, Kind::Notice, meaning.to_string());
        }
    }

    fn happened(&mut self, at_ns: u64, axis: Option<usize>, kind: Kind, text: String) {
        self.recording.add(&Item::Event(Happening {
            at_us: at_ns / 1_000,
            axis,
            kind,
            text,
            times: 1,
        }));
    }

    fn outcome(&self) -> Outcome {
        let faults = self.recording.happenings.iter();
        let faults = faults.filter(|event| event.kind == Kind::Fault).count();
        let mut facts = vec![format!(
            "{} of set-points, about {} us apart. Set-points are the sums of the steps on the bus; positions are those that the drives reported, taken as command counts.",
            counted(self.row, "row", "rows"),
            self.recording.about.cycle_us
        )];
        for (id, drive) in &self.drives {
            if drive.set_points > 0 && !drive.is_anchored {
                facts.push(format!(
                    "Drive {id}: the log has no position of it, so its set-points count from 0."
                ));
            }
        }
        if self.repeated > 0 {
            facts.push(format!(
                "{} came twice within 200 us, and both count: either the master sent two, or CAN repeated one after an error, which a drive takes twice.",
                counted(self.repeated, "set-point", "set-points"),
            ));
        }
        let axis = |drive: &Drive| AxisOutcome {
            set_points: Some(drive.set_points),
            ..AxisOutcome::default()
        };
        Outcome {
            verdict: if faults == 0 {
                "The log shows no alarm.".to_owned()
            } else {
                format!("The log shows {}.", counted(faults, "alarm", "alarms"))
            },
            is_good: faults == 0,
            facts,
            // In ascending order of the drives, as the axes are now.
            axes: self.drives.values().map(axis).collect(),
        }
    }
}

#[cfg(test)]
mod tests;
