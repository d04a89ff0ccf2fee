//! Images that make one call a known number of times: what a call takes.

use crate::emulator::Emulator;
use crate::error::Error;
use crate::size::Size;
use crate::thumb::{Builder, Variant};

/// The feature that doubles the calls.
pub(crate) const TWICE: &str = "twice";
/// Calls that the second build has more than the first; `CALLS` of the packages.
pub(crate) const CALLS: f64 = 1_000.0;

/// What an image takes.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Call {
    /// Instructions of one turn of its loop.
    pub(crate) instructions: f64,
    /// Bytes of flash of the image.
    pub(crate) flash: u64,
}

/// Builds images of a package with some calls and with twice as many, runs them on the emulated board, and tells what each takes.
///
/// # Errors
/// When an image does not build or the emulator fails.
pub(crate) fn measure<const N: usize>(
    builder: &Builder,
    emulator: &Emulator,
    package: &str,
    images: [&str; N],
) -> Result<[Call; N], Error> {
    let bins = images.iter().flat_map(|image| ["--bin", image]);
    let mut arguments: Vec<String> = bins.map(str::to_owned).collect();
    let mut calls = [Call {
        instructions: 0.0,
        flash: 0,
    }; N];
    builder.build(package, &Variant::with_arguments(&arguments))?;
    for (call, image) in calls.iter_mut().zip(images) {
        let image = builder.images().join(image);
        call.flash = Size::of_image(&image)?.flash();
        call.instructions = -(emulator.count(&image)? as f64) / CALLS;
    }
    arguments.extend(["--features", TWICE].map(str::to_owned));
    builder.build(package, &Variant::with_arguments(&arguments))?;
    for (call, image) in calls.iter_mut().zip(images) {
        let image = builder.images().join(image);
        call.instructions += emulator.count(&image)? as f64 / CALLS;
    }
    Ok(calls)
}
