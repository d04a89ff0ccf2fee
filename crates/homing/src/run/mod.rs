//! One homing from its start to its end.

mod arrive;
mod begin;
mod ready;
mod seek;
mod settle;
mod witness;

use crate::abort::Abort;
use crate::config::{Config, Method, Refusal};
use crate::frame::Frame;
use crate::inputs::Inputs;
use crate::mover::Mover;
use ready::Ready;
use settle::Settling;
use witness::Witness;

/// So many cycles of the search may wait to be sent.
const WAITING_CYCLES: f32 = 8.0;

/// What a homing has found.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct Home {
    /// The software origin with the travel: valid until the drive loses its power, its position is reset or its gear number changes, see
    /// [`AfterPowerLoss`](crate::AfterPowerLoss).
    pub frame: Frame,
    /// Where the drive reported the reference, in its counts.
    pub found_counts: i32,
    /// By how much the reference may be off, as far as it can be seen from here: the distance of the two contacts, the way in between two
    /// looks at the switch, or the change of the position at rest.
    pub uncertainty_counts: u32,
    /// The torque of the second contact, in thousandths of the peak, positive in the direction of the search; `None` for other methods.
    pub contact_permille: Option<i16>,
}

/// How far a homing is.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Progress {
    /// The target of this cycle, in counts of the drive.
    Target(i32),
    /// The axis rests at its last target.
    Found(Home),
    /// The axis has been slowed down and rests at its last target, unless the reason is [`Abort::Plan`]: then stop it.
    Failed(Abort),
}

/// The reference and how it was found.
#[derive(Debug, Clone, Copy)]
struct Found {
    counts: i32,
    uncertainty_counts: u32,
    permille: Option<i16>,
}

/// What the axis does.
#[derive(Debug, Clone, Copy)]
enum Phase {
    /// It stands, and what is needed is read.
    Ready(Ready),
    /// Off a switch that was operated at the start.
    Leave(Settling),
    /// A little further, so that the search starts beside the edge.
    Clear(Settling),
    /// Fast towards the reference.
    Search(Settling),
    /// Off the reference that was found here.
    Retreat(i32, Settling),
    /// Slowly towards it again.
    Again(i32, Settling),
    /// To rest behind the edge of a switch.
    BehindEdge(Found, Settling),
    /// Off the reference, for good.
    Part(Found, Settling),
    /// To rest, for this reason.
    Ending(Abort, Settling),
    /// The set-points go back to where the shaft is, for this reason.
    Relieving(Abort),
    /// Over.
    Over(Result<Home, Abort>),
}

/// The homing of one axis.
///
/// Call [`Self::cycle`] once a cycle while the drive follows set-points, and hand its target on. The homing counts cycles, not time: one
/// that is late makes the motion slower and no jump. Where set-points wait to be sent it waits too.
#[derive(Debug, Clone, Copy)]
pub struct Homing {
    config: Config,
    mover: Mover,
    /// Where the axis stood at the start.
    start_counts: i32,
    witness: Witness,
    phase: Phase,
    is_cancelled: bool,
}

impl Homing {
    /// A homing of an axis whose set-points rest at `sent_counts`.
    ///
    /// # Errors
    /// [`Refusal`]: what cannot work, before anything moves.
    pub fn new(config: Config, sent_counts: i32) -> Result<Self, Refusal> {
        config.check()?;
        config.check_origin(config.reach(sent_counts)?)?;
        Ok(Self {
            config,
            mover: Mover::at_rest(sent_counts),
            start_counts: sent_counts,
            witness: Witness::default(),
            phase: Phase::Ready(Ready::default()),
            is_cancelled: false,
        })
    }

    /// One cycle: looks at the inputs and tells the target.
    pub fn cycle(&mut self, now_us: u64, inputs: &Inputs) -> Progress {
        if let Err(abort) = self.step(now_us, inputs) {
            self.give_up(abort);
        }
        match self.phase {
            Phase::Over(Ok(home)) => Progress::Found(home),
            Phase::Over(Err(abort)) => Progress::Failed(abort),
            _ => {
                if !self.is_behind(inputs) {
                    self.mover.advance();
                }
                Progress::Target(self.mover.set_point())
            }
        }
    }

    /// Whether set-points wait to be sent: the motion waits for them.
    fn is_behind(&self, inputs: &Inputs) -> bool {
        let owed = self.mover.set_point().abs_diff(inputs.sent_counts);
        owed as f32 > WAITING_CYCLES * self.config.search.velocity()
    }

    /// Slows the axis down and ends with [`Abort::Cancelled`]; nothing changes where it has ended.
    pub const fn cancel(&mut self) {
        self.is_cancelled = true;
    }

    fn step(&mut self, now_us: u64, inputs: &Inputs) -> Result<(), Abort> {
        match self.phase {
            Phase::Over(_) => return Ok(()),
            Phase::Ending(abort, settling) => {
                return self.come_to_rest(abort, settling, now_us, inputs);
            }
            Phase::Relieving(abort) => {
                if self.mover.is_at_rest() {
                    self.phase = Phase::Over(Err(abort));
                }
                return Ok(());
            }
            _ if self.is_cancelled => return Err(Abort::Cancelled),
            Phase::Ready(ready) => return self.get_ready(ready, now_us, inputs),
            _ => {}
        }
        self.witness.check_age(&self.config, now_us, inputs)?;
        match self.config.method {
            // Nothing moves: it was over when it was ready.
            Method::Here => Ok(()),
            Method::HardStop(stop) => self.seek_stop(&stop, now_us, inputs),
            Method::Switch(switch) => self.seek_switch(&switch, now_us, inputs),
        }
    }

    /// 1 or -1.
    fn sign(&self) -> i32 {
        self.config
            .method
            .direction()
            .map_or(1, |direction| direction.sign())
    }

    /// A place so far ahead in the direction of the search; the reach was checked.
    fn ahead(&self, from: i32, counts: u32) -> i32 {
        let way = i64::from(self.sign()) * i64::from(counts);
        let end = i64::from(from) + way;
        i32::try_from(end).unwrap_or(from)
    }

    /// The same behind.
    fn behind(&self, from: i32, counts: u32) -> i32 {
        let way = i64::from(self.sign()) * i64::from(counts);
        i32::try_from(i64::from(from) - way).unwrap_or(from)
    }

    fn give_up(&mut self, abort: Abort) {
        if let Phase::Ready(_) = self.phase {
            self.phase = Phase::Over(Err(abort));
            return;
        }
        self.phase = match self.mover.stop(&self.config.search) {
            Ok(()) => Phase::Ending(abort, Settling::default()),
            Err(error) => Phase::Over(Err(error.into())),
        };
    }

    /// A motor that pushes is relieved: the set-points go there.
    fn relieve(&mut self, abort: Abort, counts: i32) {
        self.phase = match self.mover.go_to(counts, &self.config.search) {
            Ok(()) => Phase::Relieving(abort),
            Err(error) => Phase::Over(Err(error.into())),
        };
    }

    /// Where the shaft is, as far as that is known.
    fn place_of_relief(&self, now_us: u64, inputs: &Inputs) -> Option<i32> {
        let limit_us = u64::from(self.config.watch.max_age_us);
        let position = inputs.position?;
        (position.age_us(now_us) <= limit_us).then_some(position.value)
    }

    /// Slowed down: whether the axis has met something meanwhile shows in the next position.
    fn come_to_rest(
        &mut self,
        abort: Abort,
        mut settling: Settling,
        now_us: u64,
        inputs: &Inputs,
    ) -> Result<(), Abort> {
        let distance = self.distance_at_rest(&mut settling, now_us, inputs);
        let has_waited = self.is_unanswered(&mut settling, now_us);
        self.phase = Phase::Ending(abort, settling);
        let place = self.place_of_relief(now_us, inputs);
        let still = self.config.watch.still_counts;
        match (place, distance) {
            (Some(counts), Some(distance)) if distance > still => self.relieve(abort, counts),
            (Some(_), None) if !has_waited => {}
            _ if self.mover.is_at_rest() => self.phase = Phase::Over(Err(abort)),
            _ => {}
        }
        Ok(())
    }

    fn finish(&mut self, found: Found) -> Result<(), Abort> {
        // It was checked for the reach; a drive that reports a place beyond it has found nothing.
        let origin = found.counts.checked_sub(self.config.reference_counts);
        let origin = origin.ok_or(Abort::NotFound {
            way_counts: self.config.way_counts,
        })?;
        self.phase = Phase::Over(Ok(Home {
            frame: Frame::new(origin, self.config.travel),
            found_counts: found.counts,
            uncertainty_counts: found.uncertainty_counts,
            contact_permille: found.permille,
        }));
        Ok(())
    }
}

#[cfg(test)]
mod tests;
