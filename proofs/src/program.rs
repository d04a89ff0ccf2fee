//! A program, line by line: any bytes, any settings. Not the texts of errors: those with lengths in them need the formatting of floats.

use program::{Action, Interpreter, Settings};
use trajectory::Position;

use crate::opaque::{bits, consume, flag, word};

/// Reads lines until there is none.
pub fn exercise() {
    let mut interpreter = Interpreter::new(Settings {
        axes: [flag(), flag(), flag()],
        start: [position(); 3],
        home: [position(); 3],
        rapid_um_per_min: float(),
        tolerance_um: float(),
    });
    let mut line = [0; 300];
    while flag() {
        for byte in &mut line {
            *byte = word() as u8;
        }
        let length = word() as usize;
        let Some(Ok(text)) = line.get(..length).map(core::str::from_utf8) else {
            continue;
        };
        match interpreter.line(text) {
            Ok(actions) => actions
                .into_iter()
                .for_each(|action: Action| consume(action)),
            Err(error) => consume(error),
        }
        consume((interpreter.line_number(), interpreter.has_ended()));
    }
}

fn position() -> Position {
    Position::from_units(bits().cast_signed())
}

fn float() -> f32 {
    f32::from_bits(word())
}
