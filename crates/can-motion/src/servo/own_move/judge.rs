//! What readings say about a motion of the drive itself.

use bus_user::Instant;
use dyn_can::{DriveStatus, Reply, ServoMode};

use super::Kind;
use super::admit::MARGIN;
use super::tell::ms;
use crate::core::drive_move::{MoveEnd, MoveReport};
use crate::core::facts::{Goal, Latch, Motion};
use crate::core::family::{Context, Meaning};
use crate::servo::activity::Activity;
use crate::servo::drive::Servo;
use crate::servo::dyn_family::Dyn;
use crate::servo::fault::Fault;
use crate::servo::procedure::{Procedure, Run};

impl Servo {
    /// What a reply means to the motion, beside what it means to the axis.
    pub(in crate::servo) fn judge_own(
        &mut self,
        reply: Reply,
        asked_at: Instant,
        context: &Context<'_, Dyn>,
        meaning: &mut Meaning<Fault>,
    ) {
        let facts = context.view.facts;
        if self.procedures.own().is_none() || meaning.fault.is_some() {
            return;
        }
        if facts.motion == Motion::Loaded && facts.goal == Goal::SyncMove {
            if let Reply::MotorSpeed(_) = reply {
                meaning.own_move = self.sees_load(asked_at, context);
            }
            return;
        }
        if facts.motion != Motion::DriveMove {
            return;
        }
        match reply {
            Reply::DriveStatus(status) => self.own_status(status, asked_at, context),
            Reply::MotorSpeed(rpm) => self.own_stands(rpm, meaning.stands, context),
            Reply::Position(read_back) => {
                if let Some(position) = self.config.read_back.to_command_counts(read_back) {
                    let (end, fault) = self.own_position(position, context);
                    meaning.own_move = end.map(MoveReport::Ended);
                    meaning.fault = fault;
                }
            }
            Reply::DriveConfig(byte) => {
                let is_over = self
                    .procedures
                    .own()
                    .is_some_and(|own| own.is_speed() && own.is_seen && facts.is_to_stop_itself());
                let is_position = byte
                    .config()
                    .is_ok_and(|config| config.servo_mode == ServoMode::Position);
                let end = match is_position {
                    true => MoveEnd::Elsewhere,
                    false => MoveEnd::OtherMode,
                };
                meaning.own_move = is_over.then_some(MoveReport::Ended(end));
            }
            _ => {}
        }
    }

    /// A reply to what was asked a cycle after the load was accepted, by a frame with a higher identifier: also a controller that sorts
    /// its frames has sent the load before.
    fn sees_load(&mut self, asked_at: Instant, context: &Context<'_, Dyn>) -> Option<MoveReport> {
        let own = self.procedures.own_mut()?;
        let cycle_ms = context.config.cycle_us.div_ceil(1_000) as i32 + 1;
        let since_ms = i32::from(ms(asked_at).wrapping_sub(own.told_ms).cast_signed());
        own.is_seen = since_ms >= cycle_ms;
        own.is_seen.then_some(MoveReport::LoadSeen)
    }

    fn own_status(&mut self, status: DriveStatus, asked_at: Instant, context: &Context<'_, Dyn>) {
        // What was asked before the command left says nothing about it.
        let since = context.view.since(context.log.now);
        let counts = asked_at >= since + context.config.cycle_us;
        if let Some(own) = self.procedures.own_mut().filter(|_| counts) {
            own.is_idle = status.on_position() && !status.motion_busy();
        }
    }

    fn own_stands(&mut self, rpm: i16, stands: Option<bool>, context: &Context<'_, Dyn>) {
        let is_stopping = context.view.facts.is_to_stop_itself();
        let Some(own) = self.procedures.own_mut() else {
            return;
        };
        if !is_stopping || !own.is_stopping || own.has_end() {
            return;
        }
        own.is_seen = stands == Some(true);
        let magnitude = i32::from(rpm.unsigned_abs());
        if own.is_speed() && magnitude < own.end_counts {
            // It obeys; told again, a soft stop may begin anew.
            own.end_counts = magnitude;
            own.told_ms = ms(context.log.now);
        }
    }

    fn own_position(
        &mut self,
        position: i32,
        context: &Context<'_, Dyn>,
    ) -> (Option<MoveEnd>, Option<Fault>) {
        let limits = self.config.limits;
        let is_wanted = context.view.facts.goal.is_move();
        let Some(own) = self.procedures.own_mut() else {
            return (None, None);
        };
        let off = position.abs_diff(own.end_counts);
        // The start of a short move may lie within the tolerance of its end: what is no nearer to the end has left when its time is over, as
        // a drive that rests beside its set-points is there without being nearer.
        let time_us = own.limit_ms.saturating_mul(1_000 / MARGIN as u32);
        let has_left = own.start_counts == own.end_counts
            || off < position.abs_diff(own.start_counts)
            || context.view.has_lasted(context.log.now, time_us);
        let is_there = off <= limits.drift_tolerance_counts && has_left;
        let end = if is_there {
            MoveEnd::Arrived
        } else {
            MoveEnd::Elsewhere
        };
        match own.kind {
            Kind::To | Kind::By => {
                own.is_seen = true;
                if own.is_idle && (is_there || !is_wanted) {
                    return (Some(end), None);
                }
                // On its way to the end it may report that it stands, a moment before it moves.
                own.is_idle = false;
            }
            Kind::Square(..) | Kind::Sine(..) | Kind::Speed(_) if !is_wanted => {
                let is_over = own.is_stopping && own.is_seen && !own.is_speed();
                return (is_over.then_some(end), None);
            }
            Kind::Square(..) | Kind::Sine(..) | Kind::Speed(_) => {}
        }
        let own = *own;
        let fault = match own.kind {
            _ if !is_wanted => None,
            Kind::To | Kind::By => self.off_the_way(position, own.start_counts, own.end_counts),
            Kind::Square(amplitude, _) | Kind::Sine(amplitude, _) => {
                let swing = self.excursion(amplitude.get().into()) as i32;
                let base = own.start_counts;
                self.off_the_way(
                    position,
                    base.saturating_sub(swing),
                    base.saturating_add(swing),
                )
            }
            Kind::Speed(speed) => {
                self.travel_end(position, own.start_counts, i32::from(speed.get()))
            }
        };
        (None, fault)
    }

    /// A position that is not between two others.
    fn off_the_way(&self, position: i32, one: i32, other: i32) -> Option<Fault> {
        let (low, high) = (i64::from(one.min(other)), i64::from(one.max(other)));
        let position = i64::from(position);
        let error = (position - low).min(0) + (position - high).max(0);
        let counts = error.clamp(i32::MIN.into(), i32::MAX.into()) as i32;
        let most = self.config.limits.following_error_counts;
        (counts.unsigned_abs() > most).then_some(Fault::FollowingError { counts })
    }

    /// Constant speed that could not be stopped within the travel any more if it went on. A drive that is behind its start turns the other
    /// way, and comes to the other end.
    fn travel_end(&self, position: i32, start: i32, rpm: i32) -> Option<Fault> {
        let travel = self.config.limits.travel;
        let (at, start) = (i64::from(position), i64::from(start));
        // It may rest a little beside its start.
        let tolerance = i64::from(self.config.limits.drift_tolerance_counts);
        let is_behind = match rpm < 0 {
            true => at > start + tolerance,
            false => at < start - tolerance,
        };
        let rpm = if is_behind { -rpm } else { rpm };
        let end = at + self.speed_reach(rpm, self.own_curve()?);
        let is_inside = match rpm < 0 {
            true => end >= i64::from(travel.min_counts),
            false => end <= i64::from(travel.max_counts),
        };
        (!is_inside).then_some(Fault::TravelEnd {
            position_counts: position,
        })
    }

    /// The time of the motion, or of its stop, is over.
    pub(in crate::servo) fn tick_own(
        &self,
        context: &Context<'_, Dyn>,
        meaning: &mut Meaning<Fault>,
    ) {
        let (view, now) = (context.view, context.log.now);
        let Some(own) = self.procedures.own() else {
            return;
        };
        let is_stopped = view.facts.is_to_stop_itself();
        let ends = own.has_end() || is_stopped;
        let is_late = view.has_lasted(now, own.limit_ms.saturating_mul(1_000));
        // A stop under a fault of its own has said that it failed.
        let is_said = is_stopped && view.facts.latch == Latch::Own;
        if view.facts.motion != Motion::DriveMove || !ends || !is_late || is_said {
            return;
        }
        let read = self.feedback.position();
        let position = read.and_then(|value| self.config.read_back.to_command_counts(value));
        let late = own.late(position.unwrap_or(own.start_counts));
        // A drive that does not stop goes on being told; whether it moves is for its readings to say, and `disable` takes its power.
        meaning.fault = meaning.fault.or(Some(late));
    }

    /// Writes the configuration that was read back to position mode. What cannot be read is left to the checks.
    pub(super) fn way_back(&self) -> Activity {
        let config = self.feedback.config().and_then(|byte| byte.config().ok());
        config.map_or(Activity::None, |config| {
            Activity::Procedure(Run::way_back(Procedure::WriteConfig(
                dyn_can::DriveConfig {
                    servo_mode: ServoMode::Position,
                    ..config
                },
            )))
        })
    }
}
