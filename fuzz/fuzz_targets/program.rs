//! Any text is a program, or has a line, a column and a reason; the tool stays where a position can be.
#![no_main]

use libfuzzer_sys::fuzz_target;
use program::{Interpreter, Settings};
use trajectory::Position;

fuzz_target!(|text: &str| {
    let settings = Settings {
        axes: [true, true, false],
        start: [Position::ZERO; 3],
        home: [Position::ZERO; 3],
        rapid_um_per_min: 12e6,
        tolerance_um: 10.0,
    };
    let mut program = Interpreter::new(settings);
    for line in text.lines() {
        let before = program.place();
        match program.line(line) {
            Ok(actions) => actions.into_iter().for_each(drop),
            Err(error) => {
                assert!(!error.to_string().is_empty());
                assert_eq!(program.place(), before, "a refused line moved the tool");
                break;
            }
        }
    }
});
