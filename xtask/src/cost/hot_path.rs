//! Instructions of the hot path, counted on the emulated board: the package `hot-path`.

use super::figure::Figure;
use crate::calls;
use crate::emulator::Emulator;
use crate::error::Error;
use crate::thumb::Builder;

/// The package of the images.
pub(crate) const PACKAGE: &str = "hot-path";
const COMMAND: &str = "cargo xtask cost --only hot-path";
/// The images with a loop around nothing but inputs and results, around one call, and of two numbers of axes.
const NOTHING: &str = "nothing";
const AXIS_COMMAND: &str = "cargo xtask profile --master-alone";
const ENCODE: &str = "encode";
const DECODE_NOTHING: &str = "decode_nothing";
/// One for each number of data bytes that a position may have.
const DECODE: [&str; 4] = ["decode_1", "decode_2", "decode_3", "decode_4"];
pub(crate) const ONE_AXIS: &str = "one_axis";
pub(crate) const EIGHT_AXES: &str = "eight_axes";
const FLOOR_ONE_AXIS: &str = "floor_one_axis";
const FLOOR_EIGHT_AXES: &str = "floor_eight_axes";
const IMAGES: [&str; 11] = [
    NOTHING,
    DECODE_NOTHING,
    ENCODE,
    DECODE[0],
    DECODE[1],
    DECODE[2],
    DECODE[3],
    ONE_AXIS,
    EIGHT_AXES,
    FLOOR_ONE_AXIS,
    FLOOR_EIGHT_AXES,
];
/// Axes that the second of these two has more.
pub(crate) const FEWER_AXES: f64 = 7.0;

/// Targets.
const ENCODE_INSTRUCTIONS: f64 = 25.0;
const DECODE_INSTRUCTIONS: f64 = 30.0;
/// What the master's axis may cost, in terms of the floor.
const OF_FLOOR: f64 = 1.3;

/// Instructions of one call.
pub(crate) struct HotPath {
    /// One set-point encoded.
    encode: f64,
    /// One position reply decoded, the dearest number of bytes.
    decode: f64,
    /// One axis more in one cycle of the master alone, 1 to 8 axes.
    axis: f64,
    /// The same of code that is written for nothing else, with the same books.
    floor: f64,
}

impl HotPath {
    /// Builds the images twice and counts.
    ///
    /// # Errors
    /// When an image does not build or the emulator fails.
    pub(crate) fn measure(builder: &Builder, emulator: &Emulator) -> Result<Self, Error> {
        let calls = calls::measure(builder, emulator, PACKAGE, IMAGES)?;
        let each = |image: &str| {
            let place = IMAGES.iter().position(|name| *name == image);
            place.map_or(f64::NAN, |place| calls[place].instructions)
        };
        let dearest = DECODE.map(each).into_iter().fold(0.0, f64::max);
        Ok(Self {
            encode: each(ENCODE) - each(NOTHING),
            decode: dearest - each(DECODE_NOTHING),
            axis: (each(EIGHT_AXES) - each(ONE_AXIS)) / FEWER_AXES,
            floor: (each(FLOOR_EIGHT_AXES) - each(FLOOR_ONE_AXIS)) / FEWER_AXES,
        })
    }

    /// The figures with their targets.
    pub(crate) fn targets(&self) -> Vec<Figure> {
        let figure = |name: &str, value| Figure::new(name, value, COMMAND);
        vec![
            Figure::new(
                "instructions of one axis in one cycle, master alone: target in, frame out; target: 1.3 times the floor",
                self.axis,
                AXIS_COMMAND,
            )
            .at_most((OF_FLOOR * self.floor).round()),
            figure(
                "the floor: the same with code written for nothing else",
                self.floor,
            ),
            figure("instructions to encode a set-point", self.encode).at_most(ENCODE_INSTRUCTIONS),
            figure("instructions to decode a position reply with every check, dearest length", self.decode)
                .at_most(DECODE_INSTRUCTIONS),
        ]
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_axis_is_held_against_its_floor() {
        let hot_path = HotPath {
            encode: 16.0,
            decode: 31.0,
            axis: 131.0,
            floor: 100.0,
        };
        let verdicts: Vec<_> = hot_path.targets().iter().map(Figure::verdict).collect();
        let [axis, floor, encode, decode] = verdicts.as_slice() else {
            panic!("{verdicts:?}");
        };
        assert!(
            axis.as_deref()
                .is_some_and(|verdict| verdict.starts_with("missed"))
        );
        assert_eq!(floor.as_deref(), None);
        assert_eq!(encode.as_deref(), Some("met"));
        assert!(
            decode
                .as_deref()
                .is_some_and(|verdict| verdict.starts_with("missed"))
        );
    }
}
