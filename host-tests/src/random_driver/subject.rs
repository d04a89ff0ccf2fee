//! What the driver must know of a family: its drives, and what bytes mean.

use can_motion::facts::Facts;
use can_motion::family::Family;
use can_motion::{AxisState, Confirmation, Master};
use dyn_can::DataFrame;
use fastrand::Rng;

/// Axes of a run: the first two are group 0, the third is group 1.
pub(super) const AXES: usize = 3;

/// The group of each axis, where a family has groups.
pub(super) const GROUP_OF: [u8; AXES] = [0, 0, 1];

/// What a frame of the master does to a drive.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Command {
    /// Moves by so much.
    Step(i32),
    /// Moves to a value.
    Target(i32),
    /// Keeps a drive that is on where it is.
    Hold,
    /// Brakes a drive, or keeps one at rest.
    Brake,
    /// The same by a request, to a drive that takes no frames of a cycle.
    BrakeAsked,
    /// Switches on.
    On,
    /// Switches off.
    Off,
    /// Switches off by the frame of a cycle.
    OffInCycle,
    /// Asks.
    Ask,
    /// Changes what the drive stores, or resets it.
    Change,
    /// Moves by itself to a place.
    Go(i32),
    /// Moves by itself by so much.
    GoBy(i32),
    /// The same, when a trigger comes.
    Load(i32),
    LoadBy(i32),
    /// Starts what was loaded in every drive.
    Trigger,
    /// Nothing to one drive.
    Nothing,
}

/// What a drive told with a frame.
#[derive(Debug, Clone, Copy, Default)]
pub(super) struct Told {
    pub(super) power: Option<bool>,
    pub(super) stands: Option<bool>,
    pub(super) position: Option<i32>,
    /// It must end the motion of the group at once.
    pub(super) is_alarm: bool,
    /// It started anew.
    pub(super) is_boot_up: bool,
}

/// The request that an answer is to.
#[derive(Debug, Clone, Copy)]
pub(super) struct Asked {
    /// When the controller took it.
    pub(super) taken_us: u64,
    /// No command that switches the drive on waited when it left.
    pub(super) is_behind_switches: bool,
}

/// A frame of a drive on its way.
#[derive(Debug, Clone, Copy)]
pub(super) struct Answer {
    pub(super) due_us: u64,
    pub(super) frame: DataFrame,
    /// The request; `None` for what nobody asked for, and for the second copy of an answer.
    pub(super) asked: Option<Asked>,
}

/// What an event tells the judge.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Seen {
    Fault {
        /// Of this axis, not of its group.
        is_own: bool,
        is_bus: bool,
        /// The others of the group may slow down on their path.
        ramps: bool,
        /// The axis itself may.
        ramps_itself: bool,
        /// The drives of the group are switched off.
        disables: bool,
    },
    State {
        from: AxisState,
        to: AxisState,
        by_fault: bool,
        /// Its frame came back unsent.
        is_back: bool,
    },
    Other,
}

/// The limits of one axis.
#[derive(Debug, Clone, Copy)]
pub(super) struct AxisRules {
    pub(super) min: i32,
    pub(super) max: i32,
    pub(super) max_step: i32,
    /// Cycles from the largest step to none.
    pub(super) ramp_cycles: i32,
}

/// What was configured.
#[derive(Debug, Clone, Copy)]
pub(super) struct Rules {
    pub(super) cycle_us: u64,
    pub(super) stuck_us: u64,
    pub(super) confirm_us: u64,
    /// An answer that takes longer is not believed.
    pub(super) reply_us: u64,
    pub(super) standstill_us: u64,
    pub(super) requests_per_cycle: i32,
    pub(super) groups: [u8; AXES],
    pub(super) axes: [AxisRules; AXES],
    /// One request at a time, until its answer came or its time is over.
    pub(super) asks_one_at_a_time: bool,
    /// Answers come to questions alone, and the latest question is the one that is answered.
    pub(super) is_asked: bool,
    /// Set-points are values, not distances.
    pub(super) is_absolute: bool,
    /// Every drive gets a frame in every cycle, which switches it too.
    pub(super) has_cycle_frames: bool,
    /// The anchor is read anew after every word to enable.
    pub(super) anchors_after_enable: bool,
    /// The values are speeds.
    pub(super) is_speed: bool,
    /// An alarm takes the power of the drive.
    pub(super) alarm_frees_shaft: bool,
}

/// A family with its drives.
pub(super) trait Subject: Sized {
    type Family: Family<Frame = DataFrame>;

    /// Drives and settings of any kind.
    fn draw(random: &mut Rng) -> Self;
    fn master(&self) -> Master<AXES, Self::Family>;
    fn rules(&self) -> Rules;
    fn axis_of(frame: &DataFrame) -> Option<usize>;
    /// The identifier of the question to which a frame may be the answer.
    fn question_of(frame: &DataFrame) -> u16 {
        frame.id()
    }
    fn command(&self, frame: &DataFrame) -> Command;
    fn told(&self, frame: &DataFrame) -> Told;
    /// A drive hears a frame of the master.
    fn take(
        &mut self,
        now_us: u64,
        frame: &DataFrame,
        asked: Asked,
        random: &mut Rng,
        answers: &mut Vec<Answer>,
    );
    /// Time passes for the drives.
    fn pass(&mut self, now_us: u64, random: &mut Rng, answers: &mut Vec<Answer>);
    /// Something happens to a drive, which is named.
    fn disturb(
        &mut self,
        axis: usize,
        now_us: u64,
        random: &mut Rng,
        answers: &mut Vec<Answer>,
    ) -> &'static str;
    /// The drives that a trigger has started since this was asked last.
    fn triggered(&mut self) -> [bool; AXES] {
        [false; AXES]
    }
    fn seen(&self, axis: usize, kind: &<Self::Family as Family>::EventKind) -> Seen;
    /// Whether the drives move by themselves when they are asked to.
    const HAS_MOVES: bool = false;
    fn procedure(random: &mut Rng) -> Option<(<Self::Family as Family>::Procedure, Confirmation)>;
    /// The value that the master believes to have sent.
    fn sent(snapshot: &<Self::Family as Family>::Snapshot) -> i32;
    /// Whether that must be what the controller took.
    fn compares(facts: &Facts) -> bool {
        let _ = facts;
        true
    }
    /// Where the drive was told to be, while nothing but the master moved it since its position was read.
    fn undisturbed_position(&self, axis: usize) -> Option<i64>;
    /// The position of this drive was taken as an anchor.
    fn anchored(&mut self, axis: usize);
}
