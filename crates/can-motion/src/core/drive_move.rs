//! Motion that a drive makes by itself: what the application may ask for, how it ends, and why it may be refused.

/// The shape of a built-in wave.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub enum WaveShape {
    /// The drive jumps from one side to the other.
    Square,
    /// A sine.
    Sine,
}

/// A motion that a drive makes by itself, after one command.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub enum DriveMove {
    /// To a position, in command counts from the origin.
    To(i32),
    /// By a distance from where the axis holds, in command counts.
    By(i32),
    /// At constant speed until `stop`, in r/min of the motor, positive clockwise.
    Speed(i32),
    /// A wave around where the axis holds, until `stop`.
    Wave {
        /// The shape.
        shape: WaveShape,
        /// The amplitude in the unit of the drive.
        amplitude: i32,
        /// The frequency in hertz.
        frequency_hz: i32,
    },
}

/// How a motion of a drive ended.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub enum MoveEnd {
    /// The drive holds exactly where it was told to go: the anchor stays valid.
    Arrived,
    /// The drive holds, and where is to be read anew.
    Elsewhere,
    /// The drive is in another mode, in which it takes no set-points: it must be off to come back.
    OtherMode,
}

/// What a family reports of a motion that its drive makes by itself.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum MoveReport {
    /// The drive answered after the frame with its loaded move had left.
    LoadSeen,
    /// The motion ended.
    Ended(MoveEnd),
}

/// Why a drive is not told to make a motion by itself.
#[derive(Debug, Clone, Copy, PartialEq, Eq, thiserror::Error)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
#[non_exhaustive]
pub enum MoveRefusal {
    /// The drives of this family have no such motion, or not loaded for a trigger.
    #[error("this drive has no such motion: stream targets instead")]
    Unsupported,
    /// The motion leaves the travel of the axis.
    #[error("the motion must stay within {min}..={max} counts, it would reach {actual}")]
    Travel {
        /// The smallest position.
        min: i32,
        /// The largest position.
        max: i32,
        /// The position that it would reach.
        actual: i64,
    },
    /// A value is outside its range.
    #[error("the {quantity} must be {min}..={max} {unit}, got {actual}")]
    Range {
        /// What it is.
        quantity: &'static str,
        /// Its unit.
        unit: &'static str,
        /// The smallest value.
        min: i32,
        /// The largest value.
        max: i32,
        /// The value asked for.
        actual: i32,
    },
    /// The drive's own speed and acceleration are not known: read them first.
    #[error(
        "the drive's own maximum speed and acceleration are not known: read parameter group 2 first"
    )]
    CurveUnknown,
    /// The motion would be faster than the axis may be.
    #[error(
        "the axis may move {most} counts in a cycle, the drive would move {actual}: lower the maximum speed of the drive, or ask for less"
    )]
    TooFast {
        /// The speed limit of the axis, in counts in a cycle.
        most: u32,
        /// The speed of the drive, in counts in a cycle, rounded up.
        actual: u32,
    },
    /// The drive would accelerate more than the axis may.
    #[error(
        "the axis may change its speed by {most}/256 counts per cycle in a cycle, the drive would by {actual}/256: lower the maximum acceleration of the drive"
    )]
    TooSudden {
        /// The acceleration limit of the axis, in 1/256 counts per cycle and cycle.
        most: u32,
        /// The acceleration of the drive in the same unit, rounded up.
        actual: u32,
    },
    /// The way back needs a drive without power, and a load hangs on the axis.
    #[error(
        "the drive comes back from this motion only without power, and the load of the axis can fall"
    )]
    LoadCanFall,
    /// The way back may cost a write of the configuration, and the axis has none left now.
    #[error(
        "the way back may cost one write of the drive's configuration: all writes are used up, or the latest was too short ago"
    )]
    Wear,
}
