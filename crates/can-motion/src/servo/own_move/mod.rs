//! Motion that a DYN drive makes by itself: point-to-point moves (0x01, 0x03), loaded moves (0x16 to 0x18), constant speed (0x0A) and
//! the built-in waves (0x0B to 0x0D).
//!
//! The life of the axis is that of the core: this module knows the frames, what readings mean to the motion, and how it ends.
//!
//! - A point-to-point move has ended when the status that was asked for after its command shows no S-curve (bit 5) and the position
//!   reached (bit 0), and a position read behind that is the end of the move. It is stopped by an absolute move to where the drive can
//!   stop: a new target replaces the running one at once (DYN2 manual A1.8 section 7). That point always lies between the latest position
//!   and the end of the move, so within the travel.
//! - A wave is stopped by amplitude 0 and frequency 0, constant speed by speed 0; both have ended when the shaft stands.
//! - After constant speed the configuration is read: a drive of revision 1.6A may have switched itself to speed mode (D41). Then it is
//!   switched off, and its configuration is written back.

mod admit;
mod curve;
mod judge;
mod tell;

use dyn_can::{
    Amplitude, Counts28, DataFrame, DynFrame, FrequencyHz, FunctionCode, PdStep, Request, SpeedRpm,
    SyncKind,
};

use crate::core::drive_move::{DriveMove, WaveShape};
use crate::servo::fault::Fault;

/// Most frames that begin or end a motion.
const MOST_FRAMES: usize = 2;

/// What the drive is to do, checked.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum Kind {
    To,
    By,
    Speed(SpeedRpm),
    Square(Amplitude, FrequencyHz),
    Sine(Amplitude, FrequencyHz),
}

/// A motion that the drive makes by itself, or is to make.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) struct OwnMove {
    /// Where it began, in command counts.
    start_counts: i32,
    /// Where it ends, or is to stop; of constant speed nothing.
    end_counts: i32,
    /// How long it may take, and how long a stop may take.
    limit_ms: u32,
    /// The lower half of the milliseconds when the drive was told last.
    told_ms: u16,
    kind: Kind,
    /// Frames of the beginning that the controller accepted, or of the stop while it is stopped.
    told: u8,
    is_stopping: bool,
    /// The status that was asked for last shows that nothing moves.
    is_idle: bool,
    /// The shaft stands, or the drive has answered since its move was loaded.
    is_seen: bool,
}

impl OwnMove {
    /// Whether it has an end of its own.
    const fn has_end(&self) -> bool {
        matches!(self.kind, Kind::To | Kind::By)
    }

    /// Whether the drive may leave position mode for it.
    pub(super) const fn is_speed(&self) -> bool {
        matches!(self.kind, Kind::Speed(_))
    }

    /// The drive has answered since its move was loaded.
    pub(super) const fn is_seen(&self) -> bool {
        self.is_seen
    }

    /// The frames that begin it by themselves.
    fn begin_frames(&self) -> [Option<Request>; MOST_FRAMES] {
        match self.kind {
            Kind::To => [counts(self.end_counts).map(Request::GoAbsolutePosPtp), None],
            Kind::By => [self.distance().map(Request::GoRelativePosPtp), None],
            Kind::Speed(speed) => [Some(Request::TurnConstSpeed(speed)), None],
            // The amplitude is 0 until both are known.
            Kind::Square(amplitude, frequency) => [
                Some(Request::SsFrequency(frequency)),
                Some(Request::SquareWave(amplitude)),
            ],
            Kind::Sine(amplitude, frequency) => [
                Some(Request::SsFrequency(frequency)),
                Some(Request::SinWave(amplitude)),
            ],
        }
    }

    /// The frame that loads it for a trigger.
    fn load_frame(&self) -> Option<Request> {
        match self.kind {
            Kind::To => counts(self.end_counts).map(Request::GoAbsolutePosSync),
            Kind::By => self.distance().map(Request::GoRelativePosSync),
            _ => None,
        }
    }

    /// What starts it when it is loaded.
    const fn trigger(&self) -> SyncKind {
        match self.kind {
            Kind::By => SyncKind::Relative,
            _ => SyncKind::Absolute,
        }
    }

    /// The frames that end it, where a move with an end stops there.
    fn stop_frames(&self, stop_counts: i32) -> [Option<Request>; MOST_FRAMES] {
        let still = Amplitude::MIN;
        match self.kind {
            Kind::To | Kind::By => [counts(stop_counts).map(Request::GoAbsolutePosPtp), None],
            Kind::Speed(_) => [SpeedRpm::new(0).ok().map(Request::TurnConstSpeed), None],
            Kind::Square(..) => [
                Some(Request::SquareWave(still)),
                Some(Request::SsFrequency(FrequencyHz::MIN)),
            ],
            Kind::Sine(..) => [
                Some(Request::SinWave(still)),
                Some(Request::SsFrequency(FrequencyHz::MIN)),
            ],
        }
    }

    fn distance(&self) -> Option<Counts28> {
        counts(self.end_counts.wrapping_sub(self.start_counts))
    }

    /// A set-point from before it came back unsent: it begins elsewhere. It ends where it was to end, unless the drive has been told by
    /// how much to move.
    pub(super) fn begins_elsewhere(&mut self, unsent: PdStep, is_told: bool) {
        let counts = i32::from(unsent.get());
        self.start_counts = self.start_counts.wrapping_sub(counts);
        if is_told && !self.is_stopping && matches!(self.kind, Kind::By) {
            self.end_counts = self.end_counts.wrapping_sub(counts);
        }
    }

    /// What the application asked for.
    fn wanted(&self) -> DriveMove {
        let wave = |shape, amplitude: Amplitude, frequency: FrequencyHz| DriveMove::Wave {
            shape,
            amplitude: i32::from(amplitude.get()),
            frequency_hz: i32::from(frequency.get()),
        };
        match self.kind {
            Kind::To => DriveMove::To(self.end_counts),
            Kind::By => DriveMove::By(self.end_counts.wrapping_sub(self.start_counts)),
            Kind::Speed(speed) => DriveMove::Speed(i32::from(speed.get())),
            Kind::Square(amplitude, frequency) => wave(WaveShape::Square, amplitude, frequency),
            Kind::Sine(amplitude, frequency) => wave(WaveShape::Sine, amplitude, frequency),
        }
    }

    /// Its time is over.
    fn late(&self, position_counts: i32) -> Fault {
        Fault::NotArrived {
            counts: position_counts.wrapping_sub(self.end_counts),
        }
    }
}

/// Every target was checked against the travel, which lies within 28 bit.
fn counts(value: i32) -> Option<Counts28> {
    Counts28::new(value).ok()
}

/// Whether a request is about a motion of the drive itself.
pub(super) const fn concerns_own_move(request: &Request) -> bool {
    cfg!(feature = "procedures")
        && matches!(
            request,
            Request::GoAbsolutePosPtp(_)
                | Request::GoRelativePosPtp(_)
                | Request::TurnConstSpeed(_)
                | Request::SquareWave(_)
                | Request::SinWave(_)
                | Request::SsFrequency(_)
                | Request::GoAbsolutePosSync(_)
                | Request::GoRelativePosSync(_)
                | Request::SyncTrigger(_)
        )
}

/// Whether a frame is the trigger for every drive.
pub(super) fn is_trigger(frame: &DataFrame) -> bool {
    frame.address() == dyn_can::Address::Broadcast && frame.function() == FunctionCode::SyncTrigger
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_set_point_that_comes_back_moves_the_start_and_what_is_told_as_a_distance() {
        let after = |kind, is_stopping, is_told| {
            let mut own = OwnMove {
                start_counts: 100,
                end_counts: 500,
                limit_ms: 0,
                told_ms: 0,
                kind,
                told: 0,
                is_stopping,
                is_idle: false,
                is_seen: false,
            };
            own.begins_elsewhere(PdStep::new(-7).unwrap(), is_told);
            (own.start_counts, own.end_counts)
        };
        assert_eq!(after(Kind::By, false, false), (107, 500));
        assert_eq!(after(Kind::By, false, true), (107, 507));
        // Where it stops is a place, not a distance.
        assert_eq!(after(Kind::By, true, true), (107, 500));
        assert_eq!(after(Kind::To, false, true), (107, 500));
    }
}
