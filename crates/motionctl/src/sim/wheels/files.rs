//! Everything that a simulation of wheels writes or shows.

use std::io;
use std::path::Path;

use super::csv::Table;
use super::setup::Setup;
use crate::output::tell;
use crate::recording::{
    About, AxisAbout, Origin, Outcome, Quantity, Recorded, Recorder, Recording, RecordingOptions,
    create,
};
use crate::report;
use crate::sim::arguments::Arguments;
use crate::sim::error::SimError;
use crate::sim::live::LiveView;
use crate::sim::spectator::{Nobody, Spectator};

/// Files that are open.
pub(super) struct Files {
    pub(super) recorder: Recorder,
    /// Speeds and ways of wheels: other columns than those of positions.
    pub(super) table: Option<Table>,
    about: About,
}

impl Files {
    /// Opens everything before a run for whose results there would be no place.
    pub(super) fn open(
        arguments: &Arguments,
        setup: &Setup,
        axes: Vec<AxisAbout>,
    ) -> Result<Self, SimError> {
        let bit_ns = setup.bit_rate.bit_ns();
        let about = About {
            quantity: Quantity::Speed,
            seed: Some(setup.seed),
            ..About::now(Origin::Simulation, axes, setup.cycle_us, bit_ns)
        };
        let options = &arguments.recording;
        let twists = arguments.twist.twist.as_deref().map(Path::new);
        let inputs = [arguments.motion.file(), twists, options.csv.as_deref()];
        let taken: Vec<&Path> = inputs.into_iter().flatten().collect();
        let without_table = RecordingOptions {
            csv: None,
            ..options.clone()
        };
        let recorder = without_table.open(&about, &taken);
        Ok(Self {
            recorder: recorder.map_err(SimError::Recording)?,
            table: table_of(options.csv.as_deref(), setup)?,
            about,
        })
    }

    /// Runs with the live view or without.
    pub(super) fn watched<T>(
        mut self,
        arguments: &Arguments,
        motion_us: u64,
        run: impl FnOnce(Self, &mut dyn Spectator) -> Result<T, SimError>,
    ) -> Result<T, SimError> {
        if !arguments.live {
            return run(self, &mut Nobody);
        }
        if self.recorder.model().is_none() {
            let recording = Recording::new(self.about.clone());
            self.recorder.keep_model(recording);
        }
        let mut view = LiveView::open(self.about.axes.len(), motion_us, false)?;
        run(self, &mut view)
    }
}

fn table_of(path: Option<&Path>, setup: &Setup) -> Result<Option<Table>, SimError> {
    let Some(path) = path else {
        return Ok(None);
    };
    let file = create(path).map_err(|source| SimError::Write {
        path: path.to_owned(),
        source,
    })?;
    Table::begin(file, &setup.nodes, setup.speed_resolution)
        .map(Some)
        .map_err(|error| SimError::Log(io::Error::other(error)))
}

/// Writes the page, when one is wanted.
pub(super) fn write_page(
    arguments: &Arguments,
    recorded: &Recorded,
    outcome: &Outcome,
) -> Result<(), SimError> {
    if let (Some(recording), Some(folder)) = (&recorded.recording, &arguments.recording.report) {
        let page = report::write(folder, recording, outcome);
        let page = page.map_err(|(path, source)| SimError::Write { path, source })?;
        tell(format_args!("report: {}", page.display()));
    }
    Ok(())
}
