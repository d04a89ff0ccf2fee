//! What the lines of a program do, one after the other.

use path::{Arc, Join};
use trajectory::Position;

use crate::arc;
use crate::block::{Block, Group};
use crate::error::{ErrorKind, ProgramError};
use crate::number::Decimal;
use crate::words::At;

const AXES: [char; 3] = ['X', 'Y', 'Z'];
const CENTRES: [char; 3] = ['I', 'J', 'K'];

/// Tenths of a micrometre of a millimetre and of an inch.
const MILLIMETRE: u32 = 10_000;
const INCH: u32 = 254_000;

/// Longest dwell in milliseconds.
const LONGEST_DWELL_MS: u32 = 3_600_000;
/// Farthest coordinate, in 2^-24 micrometres: that of a path.
const FARTHEST: u64 = 1 << 52;

/// What a program does not say itself.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Settings {
    /// Which of X, Y and Z the machine has.
    pub axes: [bool; 3],
    /// Where the tool is when the program starts.
    pub start: [Position; 3],
    /// Where G28 goes to.
    pub home: [Position; 3],
    /// Feed of G0 and G28, in micrometres per minute.
    pub rapid_um_per_min: f32,
    /// Tolerance of G64 without P, in micrometres.
    pub tolerance_um: f32,
}

/// A move.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Move {
    /// Straight to a place in micrometres.
    Line([Position; 3]),
    /// On a circle or a helix.
    Arc(Arc<3>),
}

/// What a line does.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Action {
    /// Moves.
    Move {
        /// Where and how.
        path: Move,
        /// In micrometres per minute.
        feed_um_per_min: f32,
        /// How the corner before it is passed.
        join: Join,
    },
    /// Stands for a time (G4).
    Dwell {
        /// In milliseconds.
        ms: u32,
    },
    /// Stands until somebody lets it go on (M0).
    Pause,
    /// The program ends here (M2, M30).
    End,
}

/// The actions of one line, in their order.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct Actions([Option<Action>; 3]);

impl Actions {
    fn add(&mut self, action: Action) {
        if let Some(slot) = self.0.iter_mut().find(|slot| slot.is_none()) {
            *slot = Some(action);
        }
    }
}

impl IntoIterator for Actions {
    type Item = Action;
    type IntoIter = core::iter::Flatten<core::array::IntoIter<Option<Action>, 3>>;

    fn into_iter(self) -> Self::IntoIter {
        self.0.into_iter().flatten()
    }
}

/// The state of a program between two lines. A copy of it is a program at the same line.
#[derive(Debug, Clone, Copy)]
pub struct Interpreter {
    settings: Settings,
    line: u32,
    at: [i64; 3],
    motion: Option<u32>,
    /// G17, G18 or G19.
    plane: u32,
    unit: u32,
    is_incremental: bool,
    join: Join,
    feed_um_per_min: Option<f32>,
    has_ended: bool,
}

impl Interpreter {
    /// Before the first line: millimetres, absolute, the plane XY, corners passed exactly, no motion and no feed.
    #[must_use]
    pub fn new(settings: Settings) -> Self {
        Self {
            settings,
            line: 0,
            at: settings.start.map(Position::units),
            motion: None,
            plane: 17,
            unit: MILLIMETRE,
            is_incremental: false,
            join: Join::Exact,
            feed_um_per_min: None,
            has_ended: false,
        }
    }

    /// The latest line, from 1.
    #[must_use]
    pub const fn line_number(&self) -> u32 {
        self.line
    }

    /// Where the tool is behind the latest line.
    #[must_use]
    pub fn place(&self) -> [Position; 3] {
        self.at.map(Position::from_units)
    }

    /// Whether M2 or M30 has been.
    #[must_use]
    pub const fn has_ended(&self) -> bool {
        self.has_ended
    }

    /// The next line, with its end or without. What follows the end of a program is not read.
    ///
    /// # Errors
    /// [`ProgramError`]; the state is then that before the line, but for its number.
    pub fn line(&mut self, text: &str) -> Result<Actions, ProgramError> {
        self.line = self.line.saturating_add(1);
        if self.has_ended {
            return Ok(Actions::default());
        }
        let mut after = *self;
        match Block::read(text).and_then(|block| after.run(block)) {
            Ok(actions) => {
                *self = after;
                Ok(actions)
            }
            Err((column, kind)) => Err(ProgramError {
                line: self.line,
                column,
                kind,
            }),
        }
    }

    fn run(&mut self, mut block: Block) -> Result<Actions, At> {
        self.set_modes(&mut block)?;
        let mut actions = Actions::default();
        match block.code(Group::Once) {
            Some(code) if code.number == 4 => actions.add(dwell(&mut block, code.column)?),
            Some(_) => self.go_home(&mut block, &mut actions)?,
            None => self.go(&mut block, &mut actions)?,
        }
        if let Some(code) = block.miscellaneous {
            self.has_ended = code.number != 0;
            actions.add(if self.has_ended {
                Action::End
            } else {
                Action::Pause
            });
        }
        block.finish()?;
        Ok(actions)
    }

    fn set_modes(&mut self, block: &mut Block) -> Result<(), At> {
        if let Some(code) = block.code(Group::Units) {
            self.unit = if code.number == 20 { INCH } else { MILLIMETRE };
        }
        if let Some(code) = block.code(Group::Plane) {
            self.plane = code.number;
        }
        if let Some(code) = block.code(Group::Distance) {
            self.is_incremental = code.number == 91;
        }
        if let Some(code) = block.code(Group::Motion) {
            self.motion = Some(code.number);
        }
        match block.code(Group::Corners).map(|code| code.number) {
            Some(61) => self.join = Join::Exact,
            Some(_) => self.join = Join::Blend(self.tolerance(block)?),
            None => {}
        }
        if let Some((feed, column)) = block.take('F') {
            let um = feed.value() * f64::from(self.unit) * 0.1;
            if um <= 0.0 {
                return Err((column, ErrorKind::Feed));
            }
            self.feed_um_per_min = Some(um as f32);
        }
        Ok(())
    }

    fn tolerance(&self, block: &mut Block) -> Result<f32, At> {
        // With G4 in the same line, P is the dwell.
        if block.code(Group::Once).is_some() {
            return Ok(self.settings.tolerance_um);
        }
        match block.take('P') {
            None => Ok(self.settings.tolerance_um),
            Some((value, column)) => {
                let um = value.value() * f64::from(self.unit) * 0.1;
                if um <= 0.0 {
                    return Err((column, ErrorKind::Tolerance));
                }
                Ok(um as f32)
            }
        }
    }

    /// G28: to the place that is given, if one is, and from there home with the axes that are.
    fn go_home(&mut self, block: &mut Block, actions: &mut Actions) -> Result<(), At> {
        let given = AXES.map(|letter| block.first_of([letter; 3]).is_some());
        let through = self.target(block)?;
        let is_any = given.contains(&true);
        if is_any {
            self.at = through;
            actions.add(self.rapid());
        }
        let homes = self.settings.home.map(Position::units);
        let coordinates = self.at.iter_mut().zip(homes).zip(given);
        for ((at, home), is_given) in coordinates {
            if is_given || !is_any {
                *at = home;
            }
        }
        actions.add(self.rapid());
        Ok(())
    }

    fn rapid(&self) -> Action {
        Action::Move {
            path: Move::Line(self.place()),
            feed_um_per_min: self.settings.rapid_um_per_min,
            join: self.join,
        }
    }

    /// The motion of the mode, if there are words for it.
    fn go(&mut self, block: &mut Block, actions: &mut Actions) -> Result<(), At> {
        let words = block.first_of(AXES);
        let centre = block.first_of(CENTRES);
        let code = block.code(Group::Motion);
        let is_arc = matches!(self.motion, Some(2 | 3));
        // A full circle needs no coordinates.
        let Some(column) = words.or(if is_arc {
            centre.or(code.map(|code| code.column))
        } else {
            None
        }) else {
            return Ok(());
        };
        match self.motion {
            None => Err((column, ErrorKind::NoMotion)),
            Some(0) => {
                self.at = self.target(block)?;
                actions.add(self.rapid());
                Ok(())
            }
            Some(motion) => {
                let feed_um_per_min = self.feed_um_per_min.ok_or((column, ErrorKind::NoFeed))?;
                let path = if motion == 1 {
                    self.at = self.target(block)?;
                    Move::Line(self.place())
                } else {
                    Move::Arc(self.arc(block, column, motion == 2)?)
                };
                actions.add(Action::Move {
                    path,
                    feed_um_per_min,
                    join: self.join,
                });
                Ok(())
            }
        }
    }

    /// Where the coordinates of a line lead.
    fn target(&self, block: &mut Block) -> Result<[i64; 3], At> {
        let mut target = self.at;
        let axes = AXES.iter().zip(self.settings.axes);
        for (coordinate, (&letter, is_there)) in target.iter_mut().zip(axes) {
            let Some((value, column)) = block.take(letter) else {
                continue;
            };
            if !is_there {
                return Err((column, ErrorKind::NoAxis { letter }));
            }
            let far = (column, ErrorKind::Far);
            let value = value.coordinate(self.unit).ok_or(far)?;
            *coordinate = if self.is_incremental {
                coordinate.saturating_add(value)
            } else {
                value
            };
            if coordinate.unsigned_abs() > FARTHEST {
                return Err(far);
            }
        }
        Ok(target)
    }

    fn arc(&mut self, block: &mut Block, column: u32, clockwise: bool) -> Result<Arc<3>, At> {
        // From the first to the second coordinate is counterclockwise, seen against the third.
        let (plane, centres) = match self.plane {
            17 => ((0, 1), ['I', 'J']),
            18 => ((2, 0), ['K', 'I']),
            _ => ((1, 2), ['J', 'K']),
        };
        let target = self.target(block)?;
        let of = |place: [i64; 3]| {
            let coordinate = |index: usize| place.get(index).copied().unwrap_or(0);
            [coordinate(plane.0), coordinate(plane.1)]
        };
        let (start, end) = (of(self.at), of(target));
        let offsets = centres.map(|letter| block.take(letter));
        let round = match (block.take('R'), offsets) {
            (Some((radius, column)), [None, None]) => {
                let radius = within(radius, self.unit, column)?;
                arc::through(start, end, radius, clockwise).map_err(|kind| (column, kind))?
            }
            (None, [None, None]) | (Some(_), _) => return Err((column, ErrorKind::ArcForm)),
            (None, offsets) => {
                let mut offset = [0; 2];
                for (to, given) in offset.iter_mut().zip(offsets) {
                    if let Some((value, column)) = given {
                        *to = within(value, self.unit, column)?;
                    }
                }
                arc::around(start, end, offset, clockwise).map_err(|kind| (column, kind))?
            }
        };
        self.at = target;
        Ok(Arc {
            plane,
            centre: round.centre,
            sweep: round.sweep,
            end: self.place(),
        })
    }
}

/// A distance that a path can have, in 2^-24 micrometres.
fn within(value: Decimal, unit: u32, column: u32) -> Result<i64, At> {
    value
        .coordinate(unit)
        .filter(|value| value.unsigned_abs() <= FARTHEST)
        .ok_or((column, ErrorKind::Far))
}

fn dwell(block: &mut Block, column: u32) -> Result<Action, At> {
    let Some((seconds, at)) = block.take('P') else {
        return Err((column, ErrorKind::Dwell));
    };
    match seconds.milliseconds() {
        Some(ms) if ms <= LONGEST_DWELL_MS => Ok(Action::Dwell { ms }),
        _ => Err((at, ErrorKind::Dwell)),
    }
}
