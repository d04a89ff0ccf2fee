//! What a board says while it plays a motion.

use std::time::{Duration, Instant};

use board_link::host::{Incoming, StreamEnd};
use board_link::message::{BoardState, Event, Reason};

use super::follow::{Follow, POLL, Stop};
use super::outcome::End;
use super::{BoardMotion, StreamState};
use crate::board::error::BoardError;
use crate::board::words::{self, phase, refusal};
use crate::interrupt;
use crate::output::tell;
use crate::recording::Kind;
use crate::set_points::SetPointSource as _;

/// Time for the drives to arrive behind the last set-point.
const SETTLE_TIME: Duration = Duration::from_millis(500);
/// Time for a snapshot.
const LOOK_TIME: Duration = Duration::from_millis(500);

impl<M: BoardMotion> Follow<'_, M> {
    /// Takes what has come in; whether a snapshot was among it.
    pub(super) fn take(&mut self, most: Duration) -> Result<bool, Stop> {
        let Some(incoming) = self.session.next_or_earlier(most)? else {
            return Ok(false);
        };
        match incoming {
            Incoming::Snapshot(snapshot) => {
                self.traffic.snapshots += 1;
                self.recording.snapshot(&snapshot);
                if self.stream == Some(snapshot.stream) {
                    self.remote.note(&snapshot);
                    let taken = &mut self.traffic.segments_sent;
                    *taken = (*taken).max(snapshot.next_segment);
                    self.phase = snapshot.player.phase;
                    let speed = self.remote.speed();
                    self.motion.watch(&StreamState::of(&snapshot, speed));
                }
                self.latest = snapshot;
                return Ok(true);
            }
            Incoming::Event { event, .. } => self.note_event(&event),
            Incoming::EventsLost(lost) => self.traffic.lost_events += u64::from(lost),
            Incoming::Stream(end) => self.note_sent(end)?,
            Incoming::Disconnected | Incoming::Connected { .. } => {
                let lost = BoardError::Reset {
                    what: "follow the motion",
                };
                return Err(lost.into());
            }
            Incoming::Unavailable(refused) => {
                let port = self.session.name().to_owned();
                return Err(BoardError::Unavailable { port, refused }.into());
            }
            // An order that is refused because the motion has just ended.
            Incoming::Reply { .. } => {}
        }
        Ok(false)
    }

    fn note_event(&mut self, event: &Event) {
        let drives = &self.of_board.drives;
        let drive = |axis: u8| drives.get(usize::from(axis)).map(|drive| drive.get());
        let text = words::event(event, drive);
        let (place, kind) = match event {
            Event::Fault { axis, .. } => (axis.map(usize::from), Kind::Fault),
            Event::State(_) | Event::Stream { .. } => (None, Kind::State),
            _ => (None, Kind::Notice),
        };
        if kind == Kind::Fault {
            tell(&text);
        }
        if let Event::State(is) = event {
            self.latest.state = *is;
        }
        if let Event::Stream { stream, phase, .. } = event
            && self.stream == Some(*stream)
        {
            self.phase = *phase;
        }
        self.recording.happened(place, kind, text);
    }

    fn note_sent(&mut self, end: StreamEnd) -> Result<(), Stop> {
        match end {
            StreamEnd::Sent { segments } => {
                self.traffic.segments_sent = segments;
                Ok(())
            }
            // It was told to stop, and says that it takes no more.
            StreamEnd::Refused { .. } if self.is_stopping() => Ok(()),
            StreamEnd::Refused { index, refused } => {
                if let Some(index) = index {
                    self.traffic.segments_sent = index;
                }
                match (refused.reason(), index) {
                    // The segments ran out before this one came: the axes come to rest, and its phase says so.
                    (Some(Reason::Late), _) => Ok(()),
                    (_, Some(index)) => Err(End::Stopped(format!(
                        "the board refuses segment {index}: {}",
                        refusal(&refused)
                    ))),
                    (_, None) => Err(End::Stopped(format!(
                        "the board refuses the motion: {}",
                        refusal(&refused)
                    ))),
                }
            }
            // The stop recalled the beginning, which the board had not taken yet.
            StreamEnd::TimedOut if interrupt::requests() > 0 => Err(End::Interrupted),
            StreamEnd::TimedOut | StreamEnd::Lost => {
                let lost = BoardError::Reset {
                    what: "follow the motion",
                };
                Err(lost.into())
            }
        }
    }

    /// Waits for the next snapshot.
    pub(super) fn look(&mut self) -> Result<(), Stop> {
        let until = Instant::now() + LOOK_TIME;
        while !self.take(POLL)? && Instant::now() < until {}
        Ok(())
    }

    pub(super) fn why(&self) -> String {
        let faults = self.latest.axes.iter().zip(&self.of_board.drives);
        let faults: Vec<String> = faults
            .filter(|(axis, _)| axis.fault != 0)
            .map(|(axis, drive)| format!("drive {drive}: {}", words::fault_name(axis.fault)))
            .collect();
        if faults.is_empty() {
            format!(
                "the board ended the motion: {}; stream: {}",
                self.latest.state.text(),
                phase(self.phase)
            )
        } else {
            format!("the board ended the motion: {}", faults.join("; "))
        }
    }

    pub(super) fn settle(&mut self) -> Result<(), Stop> {
        let until = Instant::now() + SETTLE_TIME;
        while Instant::now() < until {
            self.take(POLL)?;
            if self.latest.state == BoardState::Faulted {
                return Err(End::Stopped(self.why()));
            }
        }
        Ok(())
    }
}
