//! Everything that a simulation of wheels writes or shows.

use std::path::Path;

use super::setup::Setup;
use crate::output::tell;
use crate::recording::{
    About, AxisAbout, Origin, Outcome, Quantity, Recorded, Recorder, Recording,
};
use crate::report;
use crate::sim::arguments::Arguments;
use crate::sim::error::SimError;
use crate::sim::live::LiveView;
use crate::sim::spectator::{Nobody, Spectator};

/// Files that are open.
pub(super) struct Files {
    pub(super) recorder: Recorder,
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
        let inputs = [arguments.motion.file(), twists];
        let taken: Vec<&Path> = inputs.into_iter().flatten().collect();
        let recorder = options.open(&about, &taken);
        Ok(Self {
            recorder: recorder.map_err(SimError::Recording)?,
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
