//! What the drive is told about a motion of its own, what is asked meanwhile, and what becomes of those frames.

use bus_user::Instant;
use dyn_can::{Address, DataFrame, ReplyKind, Request, SyncKind};

use super::{MOST_FRAMES, OwnMove};
use crate::core::drive_move::{DriveMove, MoveEnd};
use crate::core::exit::{Class, may_leave};
use crate::core::facts::{Facts, Goal, Motion};
use crate::core::family::{Returned, View};
use crate::servo::activity::Activity;
use crate::servo::ask::Ask;
use crate::servo::drive::Servo;
use crate::servo::poll_kind::PollKind;

/// The command to stop is repeated so often until the motion has ended: nothing acknowledges it.
const REPEAT_MS: u16 = 50;
/// Speed 0 is repeated when the speed did not fall for so long.
const REPEAT_SPEED_MS: u16 = 1_000;
/// A drive that does not answer is told so often.
const REPEAT_LOST_MS: u16 = 200;
/// A value that is older than this is read again while the drive moves; polls come at 20 ms.
const READING_US: u32 = 30_000;
/// A position was taken this long before its reply came in, at most, and the command to stop takes its time.
const LATENCY_MS: u64 = 2;

/// The lower half of the milliseconds.
pub(super) fn ms(at: Instant) -> u16 {
    (at.as_us() / 1_000) as u16
}

/// One bit for each kind of trigger.
const fn load_bit(kind: SyncKind) -> u8 {
    match kind {
        SyncKind::Absolute => 1,
        SyncKind::Relative => 2,
    }
}

impl Servo {
    /// What the motion needs now: its frames, then what shows how it goes.
    pub(in crate::servo) fn own_ask(
        &self,
        own: &OwnMove,
        view: &View,
        now: Instant,
    ) -> Option<Ask> {
        if let Some(class) = own_class(own, view, now) {
            return may_leave(class, &view.facts).then_some(Ask::Own(class));
        }
        let kind = self.own_reading(own, &view.facts, now)?;
        (self.slot.is_free() && !view.is_lost).then_some(Ask::Reading(kind))
    }

    fn own_reading(&self, own: &OwnMove, facts: &Facts, now: Instant) -> Option<ReplyKind> {
        match facts.motion {
            Motion::Loaded if facts.goal == Goal::SyncMove && !own.is_seen => {
                return Some(ReplyKind::MotorSpeed);
            }
            Motion::DriveMove => {}
            _ => return None,
        }
        let is_ending = facts.is_to_stop_itself() && own.has_told_to_stop();
        let kind = match (own.has_end(), own.is_speed()) {
            (true, _) if !own.is_idle => PollKind::Status,
            (false, true) if is_ending && own.is_seen => return Some(ReplyKind::DriveConfig),
            (false, _) if is_ending && !own.is_seen => return Some(ReplyKind::MotorSpeed),
            _ => PollKind::Position,
        };
        let age_us = self.feedback.age_us(kind, now);
        let is_time = age_us.is_none_or(|age_us| age_us >= READING_US);
        is_time.then_some(kind.reply_kind())
    }

    /// The request of a frame about the motion.
    pub(in crate::servo) fn own_request(&self, class: Class, now: Instant) -> Option<Request> {
        let own = self.procedures.own()?;
        match class {
            Class::DriveMove => frame_at(own.begin_frames(), own.told),
            Class::Load => own.load_frame(),
            Class::Trigger => Some(Request::SyncTrigger(own.trigger())),
            Class::DriveStop => {
                let frames = own.stop_frames(self.stop_target(own, now));
                frame_at(frames, own.stop_index())
            }
            _ => None,
        }
    }

    /// Where it is to stop. Told once, that stays.
    fn stop_target(&self, own: &OwnMove, now: Instant) -> i32 {
        if own.is_stopping {
            return own.end_counts;
        }
        let read = self.feedback.position().filter(|_| own.is_seen);
        let age_us = self.feedback.age_us(PollKind::Position, now);
        let (counts, age_ms) = match read.zip(age_us) {
            Some((read, age_us)) => {
                let counts = self.config.read_back.to_command_counts(read);
                (counts, u64::from(age_us).div_ceil(1_000))
            }
            None => (None, u64::from(ms(now).wrapping_sub(own.told_ms))),
        };
        let position = counts.unwrap_or(own.start_counts);
        self.stop_counts(own, position, age_ms.saturating_add(LATENCY_MS))
    }

    /// The frame of a request about the motion.
    pub(in crate::servo) fn own_frame(&self, request: Request) -> Option<DataFrame> {
        match request {
            Request::SyncTrigger(_) => request.encode(Address::Broadcast, &self.dialect).ok(),
            _ => self.frame_of(request),
        }
    }

    /// The controller accepted a frame about the motion.
    pub(in crate::servo) fn note_own(&mut self, request: Request, view: &View, now: Instant) {
        if let Request::GoAbsolutePosSync(_) | Request::GoRelativePosSync(_) = request
            && let Some(own) = self.procedures.own()
        {
            let kind = load_bit(own.trigger());
            self.procedures.note_load(kind);
        }
        let Some(own) = self.procedures.own_mut() else {
            return;
        };
        own.told_ms = ms(now);
        if view.facts.is_to_stop_itself() {
            if let Request::GoAbsolutePosPtp(stop) = request {
                own.end_counts = stop.get();
            }
            own.told = own.stop_index() + 1;
            own.is_stopping = true;
            if own.is_speed() {
                // The speed that it has to fall below.
                own.end_counts = i32::MAX;
            }
        } else if view.facts.goal == Goal::Move {
            own.told += 1;
            own.is_seen = false;
        } else {
            own.is_seen = false;
        }
    }

    /// The controller gave a frame about the motion back unsent.
    pub(in crate::servo) fn own_returned(&mut self, request: Request) -> Returned {
        let Some(own) = self.procedures.own_mut() else {
            return Returned::Request;
        };
        if own.is_stopping {
            let is_stop = own.stop_frames(own.end_counts).contains(&Some(request));
            if is_stop {
                own.told = 0;
                return Returned::Switch(Class::DriveStop);
            }
            // What began it never left, but what stops it did, and would itself move the drive: the place to stop is where it stands.
            if own.has_end() {
                (own.end_counts, own.told) = (own.start_counts, 0);
            }
            return Returned::Request;
        }
        if let Request::GoAbsolutePosSync(_) | Request::GoRelativePosSync(_) = request {
            return Returned::Switch(Class::Load);
        }
        let is_begun = own.told == MOST_FRAMES as u8 && matches!(request, Request::SsFrequency(_));
        own.told = 0;
        if is_begun {
            // The amplitude left: it has begun.
            return Returned::Request;
        }
        Returned::Switch(Class::DriveMove)
    }

    /// Whether a trigger of this kind may start something that was ever loaded.
    pub(in crate::servo) fn was_loaded(&self, kind: DriveMove) -> bool {
        let kind = match kind {
            DriveMove::By(_) => SyncKind::Relative,
            _ => SyncKind::Absolute,
        };
        self.procedures.loads() & load_bit(kind) != 0
    }

    /// The motion is over, or never began.
    pub(in crate::servo) fn end_own(&mut self, now: Instant, how: Option<MoveEnd>) {
        let Some(own) = self.procedures.own().copied() else {
            return;
        };
        self.procedures.follow(Activity::None);
        match how {
            Some(MoveEnd::Arrived) => {
                self.ledger.anchor(own.end_counts);
                self.drift.anchor(now);
            }
            Some(MoveEnd::OtherMode) => {
                let way_back = self.way_back();
                self.procedures.follow(way_back);
            }
            Some(MoveEnd::Elsewhere) | None => {}
        }
    }

    /// The move that is loaded.
    pub(in crate::servo) fn own_wanted(&self) -> Option<DriveMove> {
        self.procedures.own().map(OwnMove::wanted)
    }
}

impl OwnMove {
    fn stop_frame_count(&self) -> u8 {
        self.stop_frames(self.end_counts).iter().flatten().count() as u8
    }

    fn has_told_to_stop(&self) -> bool {
        self.is_stopping && self.told >= self.stop_frame_count()
    }

    /// Which frame of the stop comes next.
    fn stop_index(&self) -> u8 {
        if !self.is_stopping || self.told >= self.stop_frame_count() {
            0
        } else {
            self.told
        }
    }

    /// What has no end of its own was stopped, and its shaft stands.
    const fn is_standing(&self) -> bool {
        self.is_stopping && self.is_seen && !self.has_end()
    }
}

/// The frame that the motion needs now.
fn own_class(own: &OwnMove, view: &View, now: Instant) -> Option<Class> {
    let facts = &view.facts;
    match (facts.goal, facts.motion) {
        (Goal::Move, _) => {
            let frame = frame_at(own.begin_frames(), own.told);
            frame.map(|_| Class::DriveMove)
        }
        (Goal::SyncMove, Motion::Rest) => Some(Class::Load),
        (Goal::SyncMove, Motion::Armed) => Some(Class::Trigger),
        (Goal::SyncMove, _) => None,
        (_, Motion::DriveMove) => {
            let has_ended = own.is_idle && own.has_end() || own.is_standing();
            let repeat_ms = match (view.is_lost, own.is_speed()) {
                (_, true) => REPEAT_SPEED_MS,
                (true, false) => REPEAT_LOST_MS,
                (false, false) => REPEAT_MS,
            };
            let is_time = ms(now).wrapping_sub(own.told_ms) >= repeat_ms;
            let is_due = !own.has_told_to_stop() || is_time;
            (!has_ended && is_due).then_some(Class::DriveStop)
        }
        _ => None,
    }
}

fn frame_at(frames: [Option<Request>; MOST_FRAMES], index: u8) -> Option<Request> {
    frames.get(usize::from(index)).copied().flatten()
}
