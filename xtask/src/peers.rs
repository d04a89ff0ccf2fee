//! `cargo xtask peers`: our codec beside public ones, by the same command.

use std::fmt::Write as _;

use crate::calls::{self, Call};
use crate::emulator::Emulator;
use crate::error::Error;
use crate::output::print;
use crate::thumb::Builder;
use crate::toolchain::Preference;

const PACKAGE: &str = "peers";
/// What every image has: the loop.
const NOTHING: &str = "loop_alone";

/// A codec, its images, and what it checks.
struct Codec {
    name: &'static str,
    encode: &'static str,
    decode: &'static str,
    /// What is encoded, and what is checked then.
    set_point: &'static str,
    /// What is decoded, and what is checked then.
    position: &'static str,
}

const CODECS: [Codec; 4] = [
    Codec {
        name: "`dyn-can`",
        encode: "ours_encode",
        decode: "ours_decode",
        set_point: "step of 1 or 2 bytes: range",
        position: "number of 1 to 4 bytes: function against the request, number of bytes, range, dialect",
    },
    Codec {
        name: "`odrive-can-protocol` 0.1.3",
        encode: "odrive_encode",
        decode: "odrive_decode",
        set_point: "position and two feed-forwards, 8 bytes: that the position is a number",
        position: "position and velocity, 8 bytes: identifier, node, kind of frame, number of bytes",
    },
    Codec {
        name: "code of `dbc-codegen` 0.4",
        encode: "dbc_encode",
        decode: "dbc_decode",
        set_point: "step of 2 bytes, data without an identifier: range",
        position: "position of 4 bytes: identifier, number of bytes; not the range",
    },
    Codec {
        name: "`moteus-protocol` 0.5 (CAN FD)",
        encode: "moteus_encode",
        decode: "moteus_decode",
        set_point: "position and velocity as registers: nothing",
        position: "four registers of 16 bit: skips what does not parse, without an error",
    },
];
const IMAGES: [&str; 1 + 2 * CODECS.len()] = [
    NOTHING,
    CODECS[0].encode,
    CODECS[0].decode,
    CODECS[1].encode,
    CODECS[1].decode,
    CODECS[2].encode,
    CODECS[2].decode,
    CODECS[3].encode,
    CODECS[3].decode,
];

/// Encodes a set-point and decodes a position with our codec and with public ones, and prints what each takes as a table.
#[derive(clap::Args)]
#[command(after_help = "Examples:\n  \
    cargo xtask peers                       build, count, print the table of the README\n  \
    cargo xtask peers --toolchain source    build core from source, as on a machine without rustup's server\n\n\
    Instructions of one call, counted on the emulated board, and bytes of flash of an image with that call alone; the loop around\n\
    the call and the start-up code are taken off. The calls are in peers/src/lib.rs.")]
pub(crate) struct Arguments {
    /// Where the target's core library comes from
    #[arg(long, value_enum, default_value = "auto")]
    toolchain: Preference,
}

/// Runs the task.
///
/// # Errors
/// When an image does not build or the emulator fails.
pub(crate) fn run(arguments: &Arguments) -> Result<(), Error> {
    let builder = Builder::find(arguments.toolchain)?;
    let emulator = Emulator::prepare()?;
    let [nothing, calls @ ..] = calls::measure(&builder, &emulator, PACKAGE, IMAGES)?;
    print(table(nothing, &calls))
}

/// The calls in the order of the codecs, encode before decode.
fn table(nothing: Call, calls: &[Call]) -> String {
    let mut text = TABLE.to_owned();
    for (codec, call) in CODECS.iter().zip(calls.chunks_exact(2)) {
        let figures = |call: &Call| {
            let instructions = call.instructions - nothing.instructions;
            format!(
                "{instructions:.0} | {}",
                call.flash.saturating_sub(nothing.flash)
            )
        };
        let Codec {
            name,
            set_point,
            position,
            ..
        } = codec;
        let [encode, decode] = [&call[0], &call[1]].map(figures);
        // Writing to a string cannot fail.
        let _ = writeln!(
            text,
            "| {name} | {encode} | {set_point} | {decode} | {position} |"
        );
    }
    text
}

const TABLE: &str = "\
| codec | encode: instructions | flash | what, and what is checked | decode: instructions | flash | what, and what is checked |
|---|---|---|---|---|---|---|
";

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn each_codec_has_its_two_calls_without_the_loop() {
        let call = |instructions, flash| Call {
            instructions,
            flash,
        };
        let calls: Vec<Call> = (1..=8).map(|n| call(10.0 * f64::from(n), 1_000)).collect();
        let text = table(call(5.0, 900), &calls);
        let lines: Vec<&str> = text.lines().skip(2).collect();
        assert_eq!(lines.len(), CODECS.len());
        assert!(lines[0].starts_with("| `dyn-can` | 5 | 100 |"), "{text}");
        assert!(
            lines[1].contains("| 25 | 100 |") && lines[1].contains("| 35 | 100 |"),
            "{text}"
        );
    }

    #[test]
    fn the_images_are_those_of_the_codecs() {
        let of_codecs = CODECS.iter().flat_map(|codec| [codec.encode, codec.decode]);
        assert!(IMAGES.into_iter().skip(1).eq(of_codecs));
    }
}
