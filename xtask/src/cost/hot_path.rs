//! Instructions of the hot path, counted on the emulated board: the package `hot-path`.

use crate::emulator::Emulator;
use crate::error::Error;
use crate::thumb::{Builder, Variant};

const PACKAGE: &str = "hot-path";
/// Doubles the calls.
const TWICE: &str = "twice";
/// Calls that the second build has more than the first; `hot_path::CALLS`.
const CALLS: f64 = 1_000.0;

/// Instructions of one call.
pub(crate) struct HotPath {
    /// One set-point encoded.
    pub(crate) encode: f64,
    /// One position reply decoded.
    pub(crate) decode: f64,
    /// One axis more in one cycle of the master alone, 1 to 8 axes.
    pub(crate) axis: f64,
}

impl HotPath {
    /// Builds the images twice and counts.
    ///
    /// # Errors
    /// When an image does not build or the emulator fails.
    pub(crate) fn measure(builder: &Builder, emulator: &Emulator) -> Result<Self, Error> {
        let once = counts(builder, emulator, &[])?;
        let twice = counts(builder, emulator, &["--features".into(), TWICE.into()])?;
        let mut each = [0.0; IMAGES.len()];
        for (each, (once, twice)) in each.iter_mut().zip(once.into_iter().zip(twice)) {
            *each = (twice as f64 - once as f64) / CALLS;
        }
        let [nothing, encode, decode, one_axis, eight_axes] = each;
        Ok(Self {
            encode: encode - nothing,
            decode: decode - nothing,
            axis: (eight_axes - one_axis) / 7.0,
        })
    }
}

const IMAGES: [&str; 5] = ["nothing", "encode", "decode", "one_axis", "eight_axes"];

fn counts(
    builder: &Builder,
    emulator: &Emulator,
    features: &[String],
) -> Result<[u64; IMAGES.len()], Error> {
    let arguments = [&["--bins".to_owned()], features].concat();
    builder.build(PACKAGE, &Variant::with_arguments(&arguments))?;
    let mut counts = [0; IMAGES.len()];
    for (count, image) in counts.iter_mut().zip(IMAGES) {
        *count = emulator.count(&builder.images().join(image))?;
    }
    Ok(counts)
}
