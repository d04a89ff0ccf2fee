//! What the link needs of the application: a few queues and values, so that the cycle is never held up.

use crate::message::{BoardState, Event, FaultEntry, Info};
use crate::refused::Refused;
use crate::segment::OfAxes;

use crate::message::{AxisSnapshot, Origin};

/// Something that the application shall do in one of its next cycles.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Command {
    /// Switch the drives on.
    Enable,
    /// Slow down and switch the drives off.
    Disable,
    /// Slow down and stand; a stream stops by itself.
    Stop,
    /// End all set-points at once; [`Player::halt`](crate::segment::Player::halt), too. The drives keep their power; nothing is followed until
    /// [`Self::Enable`].
    Halt,
    /// Forget faults whose cause is gone.
    Clear,
    /// Find the origins. The result comes when they are found, or says why not.
    Home,
    /// Store the first bytes of [`Application::staging`] as settings.
    SaveSettings {
        /// So many.
        length: u32,
    },
}

/// The machine at one moment.
#[derive(Debug, Clone, PartialEq, Eq, Default)]
pub struct Machine {
    /// Where it is.
    pub state: BoardState,
    /// Its axes.
    pub axes: OfAxes<AxisSnapshot>,
    /// Cycles that were late.
    pub late_cycles: u32,
}

/// The application of a board, as the link sees it. No call may wait: the cycle is an interrupt above, so commands go through a queue to it,
/// and results, events and [`Machine`] come back through others.
///
/// The inputs rule over the link: the cycle refuses a command that they forbid, with the reason, and halts the player when they say so. It
/// asks the player for set-points only while every axis follows them.
pub trait Application {
    /// Whether axes of this application can be homed: [`Self::origin`] may be another than that of the drive.
    const HOMES: bool = false;

    /// What the board is; the link adds the number of segments and the time.
    fn info(&self) -> Info;

    /// Hands a command to the cycle; its result comes from [`Self::result`] with the same ticket. Nobody waits for the result of ticket 0.
    ///
    /// # Errors
    /// [`Refused`] at once, usually [`Reason::Busy`](crate::Reason::Busy).
    fn post(&mut self, ticket: u16, command: Command) -> Result<(), Refused>;

    /// The result of a command, if there is one.
    fn result(&mut self) -> Option<(u16, Result<(), Refused>)>;

    /// The machine as of a recent cycle.
    fn machine(&mut self) -> Machine;

    /// What the positions of an axis count from, as of a cycle that is not older than that of a [`Self::machine`] asked before.
    fn origin(&mut self, axis: usize) -> Origin {
        let _ = axis;
        Origin::OfDrive
    }

    /// Something that has happened, oldest first.
    fn event(&mut self) -> Option<Event>;

    /// The settings in force.
    fn settings(&self) -> &[u8];

    /// Room for new settings.
    fn staging(&mut self) -> &mut [u8];

    /// Whether the first bytes of [`Self::staging`] make a board that works.
    ///
    /// # Errors
    /// [`Refused`], usually [`Reason::Settings`](crate::Reason::Settings).
    fn check_settings(&mut self, length: u32) -> Result<(), Refused>;

    /// An entry of the fault log, 0 the latest.
    fn fault(&mut self, index: u32) -> Option<FaultEntry>;
}
