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
    /// Write a table with one row a cycle: positions, errors, backlog and poll ages of every axis; of hub motors speeds, ways and torques.
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
    /// The files, without the folder of the page.
    pub(crate) fn files(&self) -> impl Iterator<Item = &Path> {
        let files = [&self.candump, &self.csv, &self.mcap];
        files.into_iter().filter_map(|path| path.as_deref())
    }

    /// The same with other names, for one of several recordings of a run: `run.csv` becomes `run-TAIL.csv`.
    pub(crate) fn named_apart(&self, tail: &str) -> Self {
        let apart = |path: &Option<PathBuf>| {
            let path = path.as_ref()?;
            let mut name = path.file_stem().unwrap_or_default().to_owned();
            name.push("-");
            name.push(tail);
            if let Some(extension) = path.extension() {
                name.push(".");
                name.push(extension);
            }
            Some(path.with_file_name(name))
        };
        Self {
            candump: apart(&self.candump),
            report: apart(&self.report),
            csv: apart(&self.csv),
            mcap: apart(&self.mcap),
        }
    }

    /// Opens everything before a run for whose results there would be no place. Files of a simulation are written at once, those of
    /// a motion in real time behind queues. Files that are `taken` are the motion file and those of other recordings.
    ///
    /// # Errors
    /// When a file or the folder of the page cannot be made, or would be written over another.
    pub(crate) fn open(&self, about: &About, taken: &[&Path]) -> Result<Recorder, RecordingError> {
        let files: [(&Option<PathBuf>, Make); 3] = [
            (&self.candump, |to, about| {
                Ok(Box::new(Candump::new(to, about)))
            }),
            (&self.csv, |to, about| Ok(Box::new(Table::new(to, about)?))),
            (&self.mcap, |to, about| {
                Ok(Box::new(McapFile::new(to, about)?))
            }),
        ];
        let all: Vec<&Path> = taken.iter().copied().chain(self.files()).collect();
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

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn files_of_several_recordings_keep_their_folder_and_kind() {
        let options = RecordingOptions {
            csv: Some("out/run.csv".into()),
            report: Some("page".into()),
            ..RecordingOptions::default()
        };
        let apart = options.named_apart("can1");
        assert_eq!(apart.csv, Some("out/run-can1.csv".into()));
        assert_eq!(apart.report, Some("page-can1".into()));
        assert_eq!((apart.candump, apart.mcap), (None, None));
    }
}
