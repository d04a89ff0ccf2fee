//! `motionctl record`: the traffic of a bus in log files, one after the other.

mod arguments;
mod error;
mod rotation;

use core::fmt;
use std::process::ExitCode;
use std::sync::mpsc::{Receiver, RecvTimeoutError, TrySendError, sync_channel};
use std::time::{Duration, SystemTime, UNIX_EPOCH};

use can_decode::Frame;
use can_decode::log::Event;
use schemars::JsonSchema;
use serde::Serialize;

use crate::counted::counted;
use crate::decode::{LiveBus, Source};
use crate::exit;
use crate::interrupt;
use crate::link::{is_interface, listen_to_interface, listen_to_slcan};
use crate::output::{print, print_json, tell};
use crate::recording::candump_line;
pub(crate) use arguments::Arguments;
use error::RecordError;
use rotation::{Rotation, Rules, Written, free_bytes};

/// Frames on their way to a file: ten seconds of a full bus.
const QUEUE: usize = 1 << 17;
/// The longest wait for a frame before what waits is written.
const REST: Duration = Duration::from_millis(100);

/// What became of the frames.
#[derive(Debug, Serialize, JsonSchema)]
struct Summary {
    /// In files, those that were removed since then included.
    frames: u64,
    files: u64,
    removed_files: u64,
    removed_frames: u64,
    /// Heard and in no file.
    lost_frames: u64,
    /// Errors on the bus, which the files do not hold.
    errors_on_the_bus: u64,
    newest_file: String,
    /// Why it ended by itself.
    stopped: Option<String>,
}

/// Records until Ctrl-C.
pub(crate) fn run(arguments: &Arguments) -> Result<ExitCode, RecordError> {
    let rotation = Rotation::begin(rules(arguments), free_bytes)
        .map_err(|(path, source)| RecordError::File { path, source })?;
    let (name, link) = match (&arguments.can, &arguments.slcan) {
        (Some(interface), _) => (
            interface.as_str(),
            listen_to_interface(interface, arguments.bit_rate),
        ),
        (None, port) => {
            let port = port.as_deref().unwrap_or_default();
            let (options, acknowledge) = (arguments.port, arguments.acknowledge);
            (
                port,
                listen_to_slcan(port, options, arguments.bit_rate, acknowledge),
            )
        }
    };
    let mut bus = LiveBus::new(name, link).map_err(RecordError::Bus)?;
    interrupt::listen().map_err(RecordError::Interrupt)?;
    // Logs name network interfaces; other links have slashes or colons in their names.
    let interface = match arguments.can.as_deref() {
        Some(interface) if is_interface(interface) => interface,
        Some(_) => "pcan0",
        None => "slcan0",
    };
    let interface = interface.to_owned();
    tell(format_args!(
        "recording {name} into {}, until Ctrl-C",
        rotation.newest().display()
    ));
    let (outcome, summary) = record(&mut bus, rotation, interface)?;
    if arguments.json {
        print_json(&summary).map_err(RecordError::Print)?;
    } else {
        print(&summary).map_err(RecordError::Print)?;
    }
    outcome?;
    let is_whole = summary.lost_frames == 0 && summary.stopped.is_none();
    Ok(if is_whole {
        ExitCode::SUCCESS
    } else {
        exit::BROKEN_PROMISE.into()
    })
}

fn rules(arguments: &Arguments) -> Rules {
    const MB: u64 = 1_000_000;
    let since_1970 = SystemTime::now().duration_since(UNIX_EPOCH);
    let seconds = since_1970.map_or(0, |time| time.as_secs());
    Rules {
        folder: arguments.folder.clone(),
        stem: format!("{}-{}", arguments.name, stamp(seconds)),
        file_bytes: arguments.file_mb * MB,
        keep: arguments.keep,
        least_free_bytes: arguments.least_free_mb.saturating_mul(MB),
    }
}

/// A time as names of files have it: `20260301T123005Z`.
fn stamp(unix_s: u64) -> String {
    let seconds = i64::try_from(unix_s).unwrap_or(0);
    let time = time::OffsetDateTime::from_unix_timestamp(seconds);
    let time = time.unwrap_or(time::OffsetDateTime::UNIX_EPOCH);
    format!(
        "{:04}{:02}{:02}T{:02}{:02}{:02}Z",
        time.year(),
        u8::from(time.month()),
        time.day(),
        time.hour(),
        time.minute(),
        time.second()
    )
}

/// The bus in this thread, the files in another: a slow disk costs no frame as long as the queue has room.
fn record(
    bus: &mut LiveBus,
    rotation: Rotation,
    interface: String,
) -> Result<(Result<(), RecordError>, Summary), RecordError> {
    let (frames, to_write) = sync_channel(QUEUE);
    let writer = std::thread::Builder::new()
        .name("files".to_owned())
        .spawn(move || write_all(rotation, &interface, &to_write))
        .map_err(RecordError::Interrupt)?;
    let (mut lost, mut errors) = (0, 0);
    let mut is_told = false;
    let outcome = loop {
        let heard = match bus.next() {
            Ok(Some(heard)) => heard.what,
            Ok(None) => break Ok(()),
            Err(error) => break Err(RecordError::Bus(error)),
        };
        let Ok(Some(entry)) = heard else { continue };
        let Event::Frame(frame) = entry.event else {
            errors += 1;
            continue;
        };
        let sent = frames.try_send((entry.at_ns.unwrap_or_default(), frame));
        match sent {
            Ok(()) => {}
            Err(TrySendError::Full(_)) => {
                lost += 1;
                if !is_told {
                    tell("frames are being lost: the disk is slower than the bus");
                }
                is_told = true;
            }
            // The files have ended, and the user was told why.
            Err(TrySendError::Disconnected(_)) => lost += 1,
        }
    };
    drop(frames);
    let end = writer.join().unwrap_or_else(|_| End {
        stopped: Some("the thread that writes the files has ended".to_owned()),
        ..End::default()
    });
    let summary = Summary {
        frames: end.written.lines,
        files: end.written.files,
        removed_files: end.written.removed_files,
        removed_frames: end.written.removed_lines,
        lost_frames: lost + end.lost,
        errors_on_the_bus: errors,
        newest_file: end.newest,
        stopped: end.stopped,
    };
    Ok((outcome, summary))
}

/// How the files ended.
#[derive(Debug, Default)]
struct End {
    written: Written,
    lost: u64,
    newest: String,
    stopped: Option<String>,
}

fn write_all(mut rotation: Rotation, interface: &str, frames: &Receiver<(u64, Frame)>) -> End {
    let mut given = 0_u64;
    let mut written = Ok(());
    while written.is_ok() {
        match frames.recv_timeout(REST) {
            Ok((at_ns, frame)) => {
                given += 1;
                written = rotation.line(&candump_line(at_ns, interface, &frame));
            }
            Err(RecvTimeoutError::Timeout) => {}
            Err(RecvTimeoutError::Disconnected) => break,
        }
        written = written.and_then(|()| rotation.rest());
    }
    let written = written.and_then(|()| rotation.flush());
    if let Err(error) = &written {
        tell(format_args!("the recording ends: {error}"));
        interrupt::request();
        // Until the other thread has seen it.
        given += frames.iter().count() as u64;
    }
    End {
        lost: given - rotation.written().lines,
        written: rotation.written(),
        newest: rotation.newest().display().to_string(),
        stopped: written.err().map(|error| error.to_string()),
    }
}

impl fmt::Display for Summary {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(
            f,
            "{} in {}",
            counted(self.frames, "frame", "frames"),
            counted(self.files, "file", "files"),
        )?;
        if self.removed_files > 0 {
            write!(
                f,
                ", of which {} with {} were removed",
                counted(self.removed_files, "file", "files"),
                counted(self.removed_frames, "frame", "frames")
            )?;
        }
        write!(
            f,
            "; {} lost, {} on the bus. The newest file is {}",
            counted(self.lost_frames, "frame", "frames"),
            counted(self.errors_on_the_bus, "error", "errors"),
            self.newest_file
        )?;
        match &self.stopped {
            Some(reason) => write!(f, ". It ended by itself: {reason}"),
            None => Ok(()),
        }
    }
}

/// The shape of what `--json` prints.
pub(crate) fn schema() -> schemars::Schema {
    crate::schema::of::<Summary>()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn names_of_files_sort_by_their_time() {
        assert_eq!(stamp(1_772_368_205), "20260301T123005Z");
        assert_eq!(stamp(0), "19700101T000000Z");
    }
}
