//! Why settings are refused: a number, the axis, what was expected and what they say.

use core::fmt;

use board_link::Refused;

/// Settings that make no board that works, or that are not settings. Nothing of them is in force.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Refusal {
    /// What is wrong.
    pub kind: Kind,
    /// The axis, from 0, where it is about one.
    pub axis: Option<u8>,
    /// What was expected: the nearest value that is allowed, or the limit that is exceeded.
    pub expected: i64,
    /// What the settings say, or what follows from them.
    pub actual: i64,
}

/// What is wrong with settings. The numbers go over the link and never change.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
#[non_exhaustive]
#[repr(u16)]
pub enum Kind {
    /// The bytes are no settings: a text, an axis or a choice is cut short or unknown.
    Layout = 1001,
    /// Another version of the layout.
    Version = 1002,
    /// Bytes behind the end of the settings.
    Behind = 1003,
    /// Not enough room to write them.
    Room = 1004,
    /// The name of the board has a control character.
    Name = 1005,
    /// No axis, or too many.
    AxisCount = 1006,
    /// No drive has this id.
    Drive = 1007,
    /// The drives are not in ascending order, or one is there twice.
    Order = 1008,
    /// No drive has this gear number.
    Gear = 1009,
    /// The speed is no step of 1 to 16384 counts in a cycle.
    Speed = 1010,
    /// The acceleration is less than 1/256 count, or more than 16384 counts, per cycle and cycle.
    Acceleration = 1011,
    /// The jerk is beyond what the motion calculates with.
    Jerk = 1012,
    /// The travel is empty, or leaves the 28 bits of the protocol.
    Travel = 1013,
    /// A part of the read-back scale is 0.
    ReadBack = 1014,
    /// A position within the travel reads back as more than 28 bits.
    ReadBackRange = 1015,
    /// The tolerance at standstill is wider than the one in motion.
    Tolerance = 1016,
    /// The status is not polled, and the axis is not declared as unwatched.
    Unwatched = 1017,
    /// A poll is due more than once a cycle, or less than once in 65535 cycles.
    PollPeriod = 1018,
    /// No drive knows the bit rate.
    BitRate = 1019,
    /// The clock of the board does not make the bit rate exactly.
    BoardBitRate = 1020,
    /// No request may go out.
    Requests = 1021,
    /// The response window ends before it begins.
    ResponseWindow = 1022,
    /// The bus plan: the frames of a cycle are longer than the cycle.
    Overload = 1023,
    /// The bus plan: a set-point may be late.
    LateSetPoint = 1024,
    /// The bus plan: a request may be late.
    LateRequest = 1025,
    /// The bus plan: a reply may be late.
    LateReply = 1026,
    /// The bus plan: an alarm may be late.
    LateAlarm = 1027,
    /// The cycle of the board does not work for its master.
    Cycle = 1028,
    /// The master refuses the configuration for a reason that this version has no number for.
    Master = 1029,
    /// The firmware has no homing.
    NoHoming = 1030,
    /// The speed of a search is 0 or more than that of the axis.
    HomingSpeed = 1031,
    /// The second approach is faster than the search, or stands.
    HomingSlowSpeed = 1032,
    /// The acceleration of a search is 0 or more than that of the axis.
    HomingAcceleration = 1033,
    /// The torque of a contact is 0 or more than the most of the search.
    HomingTorque = 1034,
    /// The torque that ends a search is not within the peak.
    HomingMostTorque = 1035,
    /// The following error of a contact is 0 or not below the most of the search.
    HomingContact = 1036,
    /// The following error that ends a search is 0 or not below that of the axis.
    HomingMost = 1037,
    /// The way of a search is empty or too far.
    HomingWay = 1038,
    /// The back-off is 0 or longer than the way of the search.
    HomingBackOff = 1039,
    /// The axis would rest outside its travel.
    HomingRest = 1040,
    /// The position is read too seldom for a search.
    HomingPositionPoll = 1041,
    /// The torque is read too seldom for a search.
    HomingTorquePoll = 1042,
    /// The following error would be at its limit before a contact is seen.
    HomingTooFast = 1043,
    /// There is no such pin for a switch.
    HomingPin = 1044,
    /// The homing cannot work for a reason that this version has no number for.
    HomingSearch = 1045,
    /// The switch of another axis hangs on the pin.
    HomingPinTaken = 1046,
    /// The axis is of another group than 0.
    Group = 1047,
}

/// Number, key in a file, text and advice of each kind.
const KINDS: [(Kind, &str, &str, &str); 47] = {
    use Kind as K;
    [
        (
            K::Layout,
            "",
            "the bytes are no settings: whole up to a byte",
            "write them again, with the version of the tool that fits the board",
        ),
        (
            K::Version,
            "format",
            "another version of the settings",
            "use the tool of that version, or update the board",
        ),
        (
            K::Behind,
            "",
            "bytes behind the end of the settings",
            "write them again",
        ),
        (
            K::Room,
            "",
            "too little room for the settings, in bytes",
            "give more room",
        ),
        (
            K::Name,
            "name",
            "a control character in the name of the board",
            "use letters and digits",
        ),
        (
            K::AxisCount,
            "axis",
            "a board has 1 to 14 axes",
            "add or remove axes",
        ),
        (
            K::Drive,
            "drive",
            "a drive id is 1 to 63",
            "write the id of the drive",
        ),
        (
            K::Order,
            "drive",
            "the axes must be in ascending order of drive id, each once; the next id at least",
            "sort the axes",
        ),
        (
            K::Gear,
            "gear_number",
            "a gear number is 500 to 16384",
            "write the gear number that is stored in the drive",
        ),
        (
            K::Speed,
            "speed_rpm",
            "the speed in r/min is no step of 1 to 16384 counts in a cycle",
            "choose another speed or gear number",
        ),
        (
            K::Acceleration,
            "acceleration_rpm_per_s",
            "the acceleration in r/min per second is beyond 1/256 to 16384 counts per cycle and cycle",
            "choose another acceleration",
        ),
        (
            K::Jerk,
            "jerk_rpm_per_s2",
            "the jerk in r/min per second² is beyond what can be calculated with",
            "choose another jerk, or leave its limit out",
        ),
        (
            K::Travel,
            "travel",
            "the travel in counts is empty or beyond -2^27 to 2^27-1",
            "correct the travel",
        ),
        (
            K::ReadBack,
            "read_back",
            "both parts of the read-back scale must be at least 1",
            "correct the scale",
        ),
        (
            K::ReadBackRange,
            "travel",
            "a position reads back as more counts than the protocol has",
            "narrow the travel, or correct the read-back",
        ),
        (
            K::Tolerance,
            "drift_tolerance_counts",
            "the drift tolerance in counts exceeds the following error",
            "make it smaller",
        ),
        (
            K::Unwatched,
            "status_poll_us",
            "the status is not polled, so nobody notices a drive that left the bus",
            "poll it, or set unwatched",
        ),
        (
            K::PollPeriod,
            "poll_us",
            "polls in microseconds must be 1 to 65535 cycles apart",
            "choose another period, or 0 for none",
        ),
        (
            K::BitRate,
            "bit_rate_kbit_per_s",
            "drives know 10, 20, 50, 125, 250, 500, 800 and 1000 kbit/s",
            "write the bit rate that the drives are set to",
        ),
        (
            K::BoardBitRate,
            "bit_rate_kbit_per_s",
            "the clock of the board does not make this bit rate in kbit/s exactly",
            "set board and drives to another one",
        ),
        (
            K::Requests,
            "requests_per_cycle",
            "at least one request must go out in a cycle",
            "write 1 or more",
        ),
        (
            K::ResponseWindow,
            "response_max_us",
            "the longest response in microseconds is shorter than the shortest",
            "correct the two",
        ),
        (
            K::Overload,
            "drive",
            "the set-point does not fit: bit times of the cycle",
            "poll less often, or leave axes out",
        ),
        (
            K::LateSetPoint,
            "drive",
            "the set-point may be late: bit times",
            "poll less often, narrow the response window, or leave axes out",
        ),
        (
            K::LateRequest,
            "requests_per_cycle",
            "the last request of a cycle may be late: bit times",
            "allow fewer requests, or leave axes out",
        ),
        (
            K::LateReply,
            "response_max_us",
            "a reply may be late: bit times",
            "poll less often, narrow the response window, or leave axes out",
        ),
        (
            K::LateAlarm,
            "axis",
            "an alarm may be late: bit times",
            "poll less often, or leave axes out",
        ),
        (
            K::Cycle,
            "",
            "the cycle of the board must be 250 to 1000000 us",
            "build the firmware with another cycle",
        ),
        (
            K::Master,
            "",
            "the master refuses the configuration",
            "compare with an example",
        ),
        (
            K::NoHoming,
            "homing",
            "the firmware has no homing: version of the settings",
            "build it with `cargo fw --link --homing`, or leave the homing out",
        ),
        (
            K::HomingSpeed,
            "homing_speed_rpm",
            "the speed of a homing in r/min is not 1 to that of the axis",
            "choose another speed",
        ),
        (
            K::HomingSlowSpeed,
            "homing_slow_speed_rpm",
            "the speed of the second approach in r/min is not 1 to that of the search",
            "choose another speed",
        ),
        (
            K::HomingAcceleration,
            "homing_acceleration_rpm_per_s",
            "the acceleration of a homing in r/min per second is not 1 to that of the axis",
            "choose another acceleration",
        ),
        (
            K::HomingTorque,
            "homing_torque_permille",
            "the torque of a contact in thousandths of the peak is not 1 to the most",
            "choose another torque",
        ),
        (
            K::HomingMostTorque,
            "homing_most_torque_permille",
            "the torque that ends a homing is not 1 to 1000 thousandths of the peak",
            "choose another torque",
        ),
        (
            K::HomingContact,
            "homing_contact_millidegrees",
            "the following error of a contact in counts is not 1 to less than the most",
            "choose another following error",
        ),
        (
            K::HomingMost,
            "homing_most_millidegrees",
            "the following error that ends a homing in counts is not 1 to less than that of the axis",
            "make it smaller, or following_error_counts larger",
        ),
        (
            K::HomingWay,
            "homing_way_millidegrees",
            "the way of a homing in counts is not 1 to 2^26",
            "choose another way",
        ),
        (
            K::HomingBackOff,
            "homing_back_off_millidegrees",
            "the back-off in counts is not 1 to the way of the homing",
            "choose another back-off",
        ),
        (
            K::HomingRest,
            "homing_reference_millidegrees",
            "after its homing the axis would rest outside its travel, in counts",
            "choose another reference, back-off or travel",
        ),
        (
            K::HomingPositionPoll,
            "position_poll_us",
            "a homing needs the position at least every so many microseconds",
            "poll it, or more often",
        ),
        (
            K::HomingTorquePoll,
            "torque_poll_us",
            "a homing to a stop needs the torque at least every so many microseconds",
            "poll it, or more often",
        ),
        (
            K::HomingTooFast,
            "homing_speed_rpm",
            "the homing is too fast for a contact to be seen in time, in r/min",
            "choose a slower one, or a larger homing_most_millidegrees",
        ),
        (
            K::HomingPin,
            "homing_switch_pin",
            "a switch hangs on a pin of port C, 3 to 12, on an STM32F405 to 11",
            "choose one of them",
        ),
        (
            K::HomingSearch,
            "homing",
            "the homing cannot work",
            "compare with an example",
        ),
        (
            K::HomingPinTaken,
            "homing_switch_pin",
            "the switch of another axis hangs on this pin, and would not say which of both is there",
            "give each axis a switch and a pin of its own",
        ),
        (
            K::Group,
            "group",
            "all axes of a board are of group 0: one stream moves them, so they stop together",
            "leave it out, or write 0",
        ),
    ]
};

impl Kind {
    /// Every kind, by number.
    pub fn all() -> impl Iterator<Item = Self> {
        KINDS.iter().map(|row| row.0)
    }

    /// The number on the wire.
    #[must_use]
    pub const fn number(self) -> u16 {
        self as u16
    }

    /// The key of a file that it is about, or the end of it; empty where there is none.
    #[must_use]
    pub fn key(self) -> &'static str {
        self.row().1
    }

    /// What is wrong.
    #[must_use]
    pub fn text(self) -> &'static str {
        self.row().2
    }

    /// What to do.
    #[must_use]
    pub fn advice(self) -> &'static str {
        self.row().3
    }

    fn row(self) -> (Self, &'static str, &'static str, &'static str) {
        let row = KINDS.iter().find(|row| row.0 == self);
        row.copied().unwrap_or((self, "", "", ""))
    }

    pub(crate) const fn because(self, expected: i64, actual: i64) -> Refusal {
        Refusal {
            kind: self,
            axis: None,
            expected,
            actual,
        }
    }

    pub(crate) const fn at(self, axis: usize, expected: i64, actual: i64) -> Refusal {
        Refusal {
            axis: Some(axis as u8),
            ..self.because(expected, actual)
        }
    }
}

impl From<Refusal> for Refused {
    fn from(refusal: Refusal) -> Self {
        Self {
            number: refusal.kind.number(),
            axis: refusal.axis,
            expected: refusal.expected,
            actual: refusal.actual,
        }
    }
}

impl Refusal {
    /// What a board answered, where it is about settings.
    #[must_use]
    pub fn of_board(refused: &Refused) -> Option<Self> {
        let kind = Kind::all().find(|kind| kind.number() == refused.number)?;
        Some(Self {
            kind,
            axis: refused.axis,
            expected: refused.expected,
            actual: refused.actual,
        })
    }
}

impl fmt::Display for Refusal {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let Self {
            kind,
            expected,
            actual,
            ..
        } = self;
        write!(f, "refusal {}: ", kind.number())?;
        if let Some(axis) = self.axis {
            write!(f, "axis {axis}: ")?;
        }
        write!(
            f,
            "{}: expected {expected}, got {actual}; {}",
            kind.text(),
            kind.advice()
        )
    }
}

impl core::error::Error for Refusal {}

#[cfg(test)]
mod tests {
    use std::format;
    use std::string::ToString;
    use std::vec::Vec;

    use super::*;

    #[test]
    fn the_numbers_are_1001_to_1047_in_order() {
        let numbers: Vec<u16> = Kind::all().map(Kind::number).collect();
        assert_eq!(numbers, (1001..=1047).collect::<Vec<u16>>());
    }

    #[test]
    fn a_refusal_goes_over_the_link_and_back() {
        for kind in Kind::all() {
            let refusal = kind.at(3, 5, -7);
            assert_eq!(Refusal::of_board(&refusal.into()), Some(refusal));
        }
        let other = board_link::Reason::Enabled.plain();
        assert_eq!(Refusal::of_board(&other), None);
    }

    #[test]
    fn a_refusal_says_what_to_do() {
        assert_eq!(
            Kind::Gear.at(1, 500, 4).to_string(),
            "refusal 1009: axis 1: a gear number is 500 to 16384: expected 500, got 4; write the gear number that is stored in the drive"
        );
    }

    #[test]
    fn the_readme_lists_every_number() {
        let readme = include_str!("../README.md");
        for kind in Kind::all() {
            let row = format!("| {} | {} |", kind.number(), kind.text());
            assert!(readme.contains(&row), "README.md has no row {row}");
        }
    }
}
