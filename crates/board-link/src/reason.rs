//! The reasons for which a board refuses a request: numbers, units, texts.

/// What the values of a refusal are.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Unit {
    /// There is nothing to compare.
    Nothing,
    /// A plain number.
    Number,
    /// 2^-24 counts.
    Position,
    /// 2^-24 counts per cycle.
    Velocity,
    /// 2^-24 counts per cycle².
    Acceleration,
    /// 2^-24 counts per cycle³.
    Jerk,
    /// 2^-32 cycles.
    Time,
    /// The number of a [`BoardState`](crate::message::BoardState).
    State,
    /// With an axis the number of its fault, 0 without one; else that of a [`BoardState`](crate::message::BoardState).
    Fault,
}

/// Why a request is refused. 1 to 13 mean what they mean for [`Refusal`](crate::Refusal).
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[non_exhaustive]
#[repr(u16)]
pub enum Reason {
    /// Another number of axes than the board has.
    Axes = 1,
    /// The motion does not start where an axis stands.
    Start = 2,
    /// The start is in the past.
    Past = 3,
    /// A segment is not the next one.
    Order = 4,
    /// A segment is too short.
    Close = 5,
    /// A segment is too long, or the start too far ahead.
    Ahead = 6,
    /// An axis would leave its travel.
    Travel = 7,
    /// An axis would be too fast.
    Velocity = 8,
    /// An axis would accelerate too much.
    Acceleration = 9,
    /// The acceleration of an axis would change too fast.
    Jerk = 10,
    /// There is no room: the sender has no credit.
    Full = 11,
    /// The segments ran out before this one came, and the motion has ended.
    Late = 12,
    /// The end was announced, or the motion was told to stop.
    Ended = 13,
    /// The velocity of an axis has a step between two segments.
    VelocityStep = 14,
    /// The acceleration of an axis has a step between two segments, and its jerk is limited.
    AccelerationStep = 15,
    /// The last segment does not end at rest.
    NotAtRest = 16,
    /// An override beyond its range.
    Override = 17,
    /// Another stream than the one that was begun.
    Stream = 18,
    /// No stream was begun.
    NoStream = 19,
    /// A stream is still played.
    Moving = 20,
    /// The session does not command: it was never claimed, was released, was silent for too long, or the board was reset.
    NoSession = 21,
    /// Another session commands.
    Taken = 22,
    /// The command before is still carried out.
    Busy = 23,
    /// The axes are not enabled.
    NotEnabled = 24,
    /// The stop circuit is open.
    StopInput = 25,
    /// The enable input is not active.
    EnableInput = 26,
    /// An axis has a fault.
    Faulted = 27,
    /// The board is not in a state for this.
    NotReady = 28,
    /// The application did not answer in time.
    NoAnswer = 29,
    /// A piece of the settings is not the next one.
    Chunk = 30,
    /// The settings are too long, or not complete.
    Length = 31,
    /// The settings are not what their checksum says.
    Checksum = 32,
    /// The settings make no board that works.
    Settings = 33,
    /// Not while an axis is enabled.
    Enabled = 34,
    /// There is no such entry.
    NoEntry = 35,
    /// The board cannot do this.
    Unsupported = 36,
    /// The frame is complete, and its body is no message.
    Message = 37,
    /// The board runs another version of the protocol.
    Version = 38,
    /// The firmware failed; the board must be switched off and on.
    Locked = 39,
    /// The flash does not keep what is stored.
    Store = 40,
    /// The axis has not found its origin.
    NotHomed = 41,
    /// No axis has a homing in the settings.
    NoHoming = 42,
    /// The homing was told to stop, or its host was silent.
    HomeStopped = 43,
    /// The way of the search is at its end.
    HomeNotFound = 44,
    /// The position of the drive is too old for a search.
    HomePositionOld = 45,
    /// The torque of the drive is too old for a search.
    HomeTorqueOld = 46,
    /// The axis did not stand still when its homing began.
    HomeNotStill = 47,
    /// The motor pushes towards the stop before it moves.
    HomeTorqueAtRest = 48,
    /// The torque is at its limit and the axis follows.
    HomeTorqueOnly = 49,
    /// The axis does not follow, without the torque of a contact.
    HomeErrorOnly = 50,
    /// The torque at the stop has the sign of the other direction.
    HomeTorqueAgainst = 51,
    /// The axis does not follow on its way to a switch.
    HomeBlocked = 52,
    /// The torque is above its limit on the way to a switch.
    HomeOverload = 53,
    /// The axis is not where it should be after a move.
    HomeNotArrived = 54,
    /// The motor still pushes after it has backed off.
    HomeStillPressed = 55,
    /// The second approach found another place, or none.
    HomeNotRepeated = 56,
    /// The switch stays operated although the axis has moved off.
    HomeSwitchStuck = 57,
    /// The switch bounces, or is only a short cam.
    HomeSwitchUnsteady = 58,
    /// From the origin the travel would leave the counts of the drive.
    HomeRange = 59,
    /// A move of the search cannot be planned.
    HomePlan = 60,
}

/// A reason, the unit of its values, why it is refused and what to do.
pub(crate) type Row = (Reason, Unit, &'static str, &'static str);

/// Every reason.
pub(crate) const REASONS: [Row; 60] = {
    use Reason as R;
    use Unit as U;
    [
        (
            R::Axes,
            U::Number,
            "another number of axes than the board has",
            "send one value for each axis",
        ),
        (
            R::Start,
            U::Position,
            "the motion must start where the axis stands",
            "read the set-points again and begin from there",
        ),
        (
            R::Past,
            U::Number,
            "the start, in cycles of the board, is in the past",
            "synchronise the time, begin later",
        ),
        (
            R::Order,
            U::Number,
            "the segment is not the next one",
            "send the expected one",
        ),
        (
            R::Close,
            U::Time,
            "the segment is too short",
            "send fewer, longer segments",
        ),
        (
            R::Ahead,
            U::Time,
            "it is too long, or too far ahead",
            "divide the segment, or begin later",
        ),
        (
            R::Travel,
            U::Position,
            "beyond the travel of the axis",
            "stay within the travel, or change it in the settings",
        ),
        (
            R::Velocity,
            U::Velocity,
            "too fast",
            "give the segment more time",
        ),
        (
            R::Acceleration,
            U::Acceleration,
            "too much acceleration",
            "give the segment more time",
        ),
        (
            R::Jerk,
            U::Jerk,
            "too much jerk",
            "give the segment more time",
        ),
        (R::Full, U::Number, "the buffer is full", "wait for credit"),
        (
            R::Late,
            U::Number,
            "the segments ran out and the motion has ended",
            "begin a new stream, and send further ahead",
        ),
        (
            R::Ended,
            U::Number,
            "the motion ends: no segment is taken any more",
            "begin a new stream",
        ),
        (
            R::VelocityStep,
            U::Velocity,
            "the velocity has a step at the start of the segment",
            "start with the velocity at the end of the one before",
        ),
        (
            R::AccelerationStep,
            U::Acceleration,
            "the acceleration has a step at the start of the segment, and the jerk is limited",
            "start with the acceleration at the end of the one before",
        ),
        (
            R::NotAtRest,
            U::Velocity,
            "the last segment does not end at rest",
            "send one that does before the end",
        ),
        (
            R::Override,
            U::Number,
            "the override in percent is beyond its range",
            "send 0 to 200",
        ),
        (
            R::Stream,
            U::Number,
            "another stream than the one that was begun",
            "send its number",
        ),
        (R::NoStream, U::Number, "no stream was begun", "begin one"),
        (
            R::Moving,
            U::Number,
            "a stream is still played",
            "stop it, or wait for its end",
        ),
        (
            R::NoSession,
            U::Number,
            "the session does not command",
            "claim the command",
        ),
        (
            R::Taken,
            U::Number,
            "another session commands",
            "let it release the command first",
        ),
        (
            R::Busy,
            U::Number,
            "the command before is still carried out",
            "wait for its reply",
        ),
        (
            R::NotEnabled,
            U::State,
            "the axes are not enabled",
            "enable them first",
        ),
        (
            R::StopInput,
            U::Nothing,
            "the stop circuit is open",
            "close it at the machine",
        ),
        (
            R::EnableInput,
            U::Nothing,
            "the enable input is not active",
            "activate it at the machine",
        ),
        (
            R::Faulted,
            U::Fault,
            "the axis has a fault",
            "read it, remove its cause, clear it",
        ),
        (
            R::NotReady,
            U::State,
            "the board is in another state",
            "read its state",
        ),
        (
            R::NoAnswer,
            U::Number,
            "the application did not answer in so many cycles",
            "read the state of the board and repeat",
        ),
        (
            R::Chunk,
            U::Number,
            "the piece of the settings is not the next one",
            "continue at the expected byte",
        ),
        (
            R::Length,
            U::Number,
            "the settings have another length",
            "send as many bytes as were announced and fit",
        ),
        (
            R::Checksum,
            U::Number,
            "the settings are not what their checksum says",
            "write them again",
        ),
        (
            R::Settings,
            U::Number,
            "the settings make no board that works",
            "correct the value that the check names",
        ),
        (
            R::Enabled,
            U::Number,
            "not while an axis is enabled",
            "disable first",
        ),
        (
            R::NoEntry,
            U::Number,
            "there is no such entry",
            "ask for one below the expected number",
        ),
        (
            R::Unsupported,
            U::Nothing,
            "the board cannot do this",
            "read its info",
        ),
        (
            R::Message,
            U::Number,
            "the body of the frame is no message",
            "use the message format of this version",
        ),
        (
            R::Version,
            U::Number,
            "the board runs another version of the protocol",
            "use a host of that version, or update the board",
        ),
        (
            R::Locked,
            U::Nothing,
            "the firmware failed and enables nothing",
            "read the fault log, switch the board off and on",
        ),
        (
            R::Store,
            U::Number,
            "the flash does not keep what is stored: its status",
            "repeat it; replace the board if it fails again",
        ),
        (
            R::NotHomed,
            U::Nothing,
            "the axis has not found its origin",
            "home the axes first",
        ),
        (
            R::NoHoming,
            U::Nothing,
            "no axis has a homing in the settings",
            "write settings with one",
        ),
        (
            R::HomeStopped,
            U::Nothing,
            "the homing was stopped",
            "home again",
        ),
        (
            R::HomeNotFound,
            U::Number,
            "nothing was found within so many counts",
            "look at direction, way and switch",
        ),
        (
            R::HomePositionOld,
            U::Number,
            "the position was read too many microseconds ago",
            "look at the drive, poll its position more often",
        ),
        (
            R::HomeTorqueOld,
            U::Number,
            "the torque was read too many microseconds ago",
            "look at the drive, poll its torque more often",
        ),
        (
            R::HomeNotStill,
            U::Number,
            "the axis did not stand still at the start, in counts",
            "hold it, or wait for its load",
        ),
        (
            R::HomeTorqueAtRest,
            U::Number,
            "the motor pushes at rest already, in thousandths of its peak",
            "move the axis off the stop, or raise the torque of a contact",
        ),
        (
            R::HomeTorqueOnly,
            U::Number,
            "much torque, in thousandths of the peak, and the axis follows",
            "look for friction or a brake that is closed",
        ),
        (
            R::HomeErrorOnly,
            U::Number,
            "the axis is behind by so many counts without the torque of a contact",
            "look for a coupling or a belt that slips",
        ),
        (
            R::HomeTorqueAgainst,
            U::Number,
            "at the stop the torque has the wrong sign, in thousandths of the peak",
            "is the revision of the drive right?",
        ),
        (
            R::HomeBlocked,
            U::Number,
            "something is in the way: the axis is behind by so many counts",
            "look at the machine",
        ),
        (
            R::HomeOverload,
            U::Number,
            "something is in the way: thousandths of the peak torque",
            "look at the machine",
        ),
        (
            R::HomeNotArrived,
            U::Number,
            "the axis did not arrive, off by so many counts",
            "look at the machine",
        ),
        (
            R::HomeStillPressed,
            U::Number,
            "the axis sticks after backing off, in thousandths of the peak torque",
            "look at the machine, back off farther",
        ),
        (
            R::HomeNotRepeated,
            U::Number,
            "the second approach found another place, in counts",
            "it was no stop, or gave way: look at the machine",
        ),
        (
            R::HomeSwitchStuck,
            U::Number,
            "the switch is still operated after so many counts",
            "look at the switch, its level and the back-off",
        ),
        (
            R::HomeSwitchUnsteady,
            U::Number,
            "the switch was operated at this count and let go again",
            "look at the switch and its cam",
        ),
        (
            R::HomeRange,
            U::Number,
            "from there the travel leaves what the drive counts",
            "set the zero of the drive nearer to the axis",
        ),
        (
            R::HomePlan,
            U::Nothing,
            "the search cannot be planned",
            "correct its speeds and ways in the settings",
        ),
    ]
};

impl Reason {
    /// Every reason, by number.
    pub fn all() -> impl Iterator<Item = Self> {
        REASONS.iter().map(|row| row.0)
    }

    /// The number on the wire.
    #[must_use]
    pub const fn number(self) -> u16 {
        self as u16
    }

    /// What its values are.
    #[must_use]
    pub fn unit(self) -> Unit {
        self.row().map_or(Unit::Number, |row| row.1)
    }

    pub(crate) fn row(self) -> Option<&'static Row> {
        REASONS.iter().find(|row| row.0 == self)
    }
}
