//! The options that say what to record.

use core::fmt;
use std::io;
use std::path::{Path, PathBuf};

use super::about::{About, Origin};
use super::candump::Candump;
use super::csv::Table;
use super::keep::Keep;
use super::mcap::McapFile;
use super::model::Recording;
use super::output_file::{create, given_twice};
use super::recorder::Recorder;

/// What to record.
#[derive(Debug, Clone, Default, clap::Args)]
pub(crate) struct RecordingOptions {
    /// Write the bus traffic as a candump log; the time is the end of each frame.
    #[arg(long, value_name = "FILE")]
    pub(crate) candump: Option<PathBuf>,
    /// Write a page with pictures, DIR/index.html: positions, velocities, errors, backlog, poll ages, jitter, load, events
    /// and every frame. It needs no network.
    #[arg(long, value_name = "DIR")]
    pub(crate) report: Option<PathBuf>,
    /// Write a table with one row a cycle: positions, errors, backlog and poll ages of every axis.
    #[arg(long, value_name = "FILE")]
    pub(crate) csv: Option<PathBuf>,
    /// Write an MCAP file, for Foxglove and PlotJuggler: every cycle, every frame, every event.
    #[arg(long, value_name = "FILE")]
    pub(crate) mcap: Option<PathBuf>,
}

/// A recording that cannot begin.
#[derive(Debug)]
pub(crate) enum RecordingError {
    /// A file cannot be written.
    Write { path: PathBuf, source: io::Error },
    /// Two files are one.
    SameFile { path: PathBuf },
}

impl fmt::Display for RecordingError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Write { path, source } => {
                write!(f, "cannot write {}: {source}", path.display())
            }
            Self::SameFile { path } => write!(
                f,
                "{} is given twice: the recording would be written over it",
                path.display()
            ),
        }
    }
}

impl std::error::Error for RecordingError {}

/// Makes one kind of file.
type Make = fn(Box<dyn io::Write + Send>, &About) -> io::Result<Box<dyn Keep>>;

impl RecordingOptions {
    /// Opens everything before a run for whose results there would be no place. Files of a simulation are written at once, those of
    /// a motion in real time behind queues. `input` is the motion file.
    ///
    /// # Errors
    /// When a file or the folder of the page cannot be made, or would be written over another.
    pub(crate) fn open(
        &self,
        about: &About,
        input: Option<&Path>,
    ) -> Result<Recorder, RecordingError> {
        let files: [(&Option<PathBuf>, Make); 3] = [
            (&self.candump, |to, about| {
                Ok(Box::new(Candump::new(to, about)))
            }),
            (&self.csv, |to, about| Ok(Box::new(Table::new(to, about)?))),
            (&self.mcap, |to, about| {
                Ok(Box::new(McapFile::new(to, about)?))
            }),
        ];
        let outputs = files.iter().filter_map(|(path, _)| path.as_deref());
        let all: Vec<&Path> = input.into_iter().chain(outputs).collect();
        if let Some(path) = given_twice(&all) {
            let path = path.to_owned();
            return Err(RecordingError::SameFile { path });
        }
        let mut recorder = Recorder::default();
        let waits = about.origin != Origin::Bus;
        for (path, make) in files {
            let Some(path) = path else { continue };
            let failed = |source| RecordingError::Write {
                path: path.clone(),
                source,
            };
            let name = path.display().to_string();
            let to = create(path).map_err(failed)?;
            let keep = make(Box::new(to), about).map_err(failed)?;
            if waits {
                recorder.add_direct(name, keep);
            } else {
                recorder.add_queued(name, keep).map_err(failed)?;
            }
        }
        if let Some(folder) = &self.report {
            let failed = |source| RecordingError::Write {
                path: folder.clone(),
                source,
            };
            std::fs::create_dir_all(folder).map_err(failed)?;
            let recording = Recording::new(about.clone());
            if waits {
                recorder.keep_model(recording);
            } else {
                let name = folder.display().to_string();
                recorder
                    .keep_model_queued(name, recording)
                    .map_err(failed)?;
            }
        }
        Ok(recorder)
    }
}
