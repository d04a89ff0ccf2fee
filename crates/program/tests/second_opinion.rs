//! The words of random lines, compared with those that the crate `gcode` finds: which letters, which values. And no text panics.

use gcode::core::{
    BlockVisitor, CommandVisitor, ControlFlow, Diagnostics, Number, ProgramVisitor, Span, Value,
};
use program::{Action, Interpreter, Move, Settings};
use proptest::prelude::*;
use trajectory::Position;

#[derive(Default)]
struct Collected(Vec<(char, f32)>);

struct Part<'a>(&'a mut Collected);

impl Diagnostics for Collected {}
impl Diagnostics for Part<'_> {}

impl ProgramVisitor for Collected {
    fn start_block(&mut self) -> ControlFlow<impl BlockVisitor + '_> {
        ControlFlow::Continue(Part(self))
    }
}

impl BlockVisitor for Part<'_> {
    fn word_address(&mut self, letter: char, value: Value<'_>, _: Span) {
        self.argument(letter, value, Span::new(0, 0, 0));
    }

    fn start_general_code(&mut self, number: Number) -> ControlFlow<impl CommandVisitor + '_> {
        self.0.0.push(('G', number.major() as f32));
        ControlFlow::Continue(Part(self.0))
    }
}

impl CommandVisitor for Part<'_> {
    fn argument(&mut self, letter: char, value: Value<'_>, _: Span) {
        if let Value::Literal(value) = value {
            self.0.0.push((letter.to_ascii_uppercase(), value));
        }
    }
}

fn interpreter() -> Interpreter {
    Interpreter::new(Settings {
        axes: [true; 3],
        start: [Position::ZERO; 3],
        home: [Position::ZERO; 3],
        rapid_um_per_min: 1e6,
        tolerance_um: 1.0,
    })
}

proptest! {
    #![proptest_config(ProptestConfig { cases: 2_000, ..ProptestConfig::default() })]

    #[test]
    fn coordinates_are_those_of_the_other_reader(
        x in -9_999_999..9_999_999_i32, y in -99_999..99_999_i32, decimals in 0..4_usize, blanks in "[ \t]{0,2}", comment in "(\\([a-zA-Z0-9 ]{0,9}\\))?", is_upper: bool,
    ) {
        let number = |value: i32| format!("{:.*}", decimals, f64::from(value) / 1_000.0);
        let line = format!("G1{blanks}X{}{blanks}{comment}Y{blanks}{} F100", number(x), number(y));
        let line = if is_upper { line } else { line.to_lowercase() };
        let mut other = Collected::default();
        gcode::core::parse(&line, &mut other);
        let of = |letter| other.0.iter().find(|(other, _)| *other == letter).map(|(_, value)| *value);
        let actions: Vec<Action> = interpreter().line(&line).unwrap().into_iter().collect();
        let [Action::Move { path: Move::Line(end), feed_um_per_min, .. }] = actions[..] else {
            panic!("{actions:?}");
        };
        prop_assert_eq!(feed_um_per_min, 100_000.0);
        for (place, letter) in [(0, 'X'), (1, 'Y')] {
            let mm = end[place].units() as f64 / 16_777_216.0 / 1_000.0;
            prop_assert_eq!(mm as f32, of(letter).unwrap());
        }
    }

    #[test]
    fn any_text_is_read_or_refused(text in "\\PC{0,300}", line in "[GMXYZIJKRFPN0-9. ();%-]{0,60}") {
        let mut program = interpreter();
        for line in [text.as_str(), &line] {
            if let Err(error) = program.line(line) {
                prop_assert!(error.column >= 1 && error.column as usize <= line.len() + 1, "{error}");
            }
        }
    }
}
