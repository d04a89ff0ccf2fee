//! Which instructions ran, how often, and in which exception.

use std::collections::{BTreeMap, HashMap};

use crate::image::Image;
use crate::instructions;
use crate::names::{self, Function, Names};

/// How often each straight run of code was executed.
#[derive(Debug, Clone, Default)]
pub struct Profile {
    runs: HashMap<Run, u64>,
}

/// A straight run of code in an exception.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub struct Run {
    /// Address of its first instruction.
    pub address: u32,
    /// Its length in bytes.
    pub bytes: u32,
    /// Its length in instructions.
    pub instructions: u32,
    /// The exception, 0 for the thread.
    pub exception: u16,
}

impl Profile {
    /// A run is about to be executed.
    pub fn note(&mut self, run: Run) {
        *self.runs.entry(run).or_default() += 1;
    }

    /// How often each instruction was executed, by its address and the exception. Code that is not in the image, such as code in RAM,
    /// is booked on the first address of its run.
    #[must_use]
    pub fn instructions(&self, image: &Image) -> BTreeMap<(u32, u16), u64> {
        let mut counts = BTreeMap::new();
        for (run, &times) in &self.runs {
            let mut book = |address, times| {
                *counts.entry((address, run.exception)).or_default() += times;
            };
            match image.code(run.address, run.bytes) {
                Some(code) => {
                    instructions::offsets(code)
                        .for_each(|offset| book(run.address + offset, times));
                }
                None => book(run.address, times * u64::from(run.instructions)),
            }
        }
        counts
    }

    /// The instructions of each function in each context, an interrupt by its name.
    #[must_use]
    pub fn functions(
        &self,
        image: &Image,
        names: &Names,
    ) -> BTreeMap<Function, BTreeMap<String, u64>> {
        let mut functions: BTreeMap<Function, BTreeMap<String, u64>> = BTreeMap::new();
        for ((address, exception), times) in self.instructions(image) {
            let context = names::exception(image, exception);
            let contexts = functions.entry(names.function(address)).or_default();
            *contexts.entry(context).or_default() += times;
        }
        functions
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::image::Piece;

    const fn run(address: u32, bytes: u32, instructions: u32, exception: u16) -> Run {
        Run {
            address,
            bytes,
            instructions,
            exception,
        }
    }

    #[test]
    fn each_instruction_counts_as_often_as_its_run_in_each_exception() {
        // movs r0, #1; movw r1, #0x1234; bx lr
        let code = Piece {
            address: 0x0800_0100,
            bytes: vec![0x01, 0x20, 0x41, 0xF2, 0x34, 0x21, 0x70, 0x47],
        };
        let mut profile = Profile::default();
        profile.note(run(0x0800_0100, 8, 3, 0));
        profile.note(run(0x0800_0102, 6, 2, 0));
        profile.note(run(0x0800_0102, 6, 2, 35));
        profile.note(run(0x2000_0000, 6, 3, 35));
        let counts = profile.instructions(&Image::of_pieces(vec![code]));
        let expected = [
            ((0x0800_0100, 0), 1),
            ((0x0800_0102, 0), 2),
            ((0x0800_0102, 35), 1),
            ((0x0800_0106, 0), 2),
            ((0x0800_0106, 35), 1),
            ((0x2000_0000, 35), 3),
        ];
        assert!(counts.into_iter().eq(expected));
    }
}
