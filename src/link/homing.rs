//! Homing as the settings say, for a host that commands it: the sequence of the axes, with their drives and their switches.

use board_link::{Reason, Refused};
use board_settings::{AxisHoming, HomingSequence, HomingStep};
use can_motion::Instant;

use super::shared::SHARED;
use crate::config::{AXES, Drives, GROUP};
use crate::drives::{Board as _, BoardMaster};
use crate::home;
use crate::machine;

/// What the cycle knows of the origins.
pub(super) struct Homings {
    sequence: HomingSequence<AXES>,
    /// The command that waits for the end.
    ticket: Option<u16>,
}

/// The homings of the settings, an entry an axis.
fn plans() -> &'static [Option<AxisHoming>] {
    machine::get().map_or(&[], |machine| &machine.homings)
}

impl Homings {
    /// Nothing is known.
    pub(super) const fn new() -> Self {
        Self {
            sequence: HomingSequence::NEW,
            ticket: None,
        }
    }

    /// Begins, for a command that waits for the end.
    ///
    /// # Errors
    /// As [`HomingSequence::begin`].
    pub(super) fn begin(&mut self, ticket: u16) -> Result<(), Refused> {
        self.sequence.begin(plans())?;
        SHARED.forget_origins();
        for homing in plans().iter().flatten() {
            if let Some(pin) = homing.switch_pin {
                home::set_up_switch(pin);
            }
        }
        self.ticket = Some(ticket);
        Ok(())
    }

    /// Whether a command waits for the end.
    pub(super) const fn is_awaited(&self) -> bool {
        self.ticket.is_some()
    }

    /// Slows down the axis that searches, and ends.
    pub(super) fn cancel(&mut self) {
        self.sequence.cancel();
    }

    /// The command does not wait any more, because of something that ends the set-points: it is answered so, with the axis that searches.
    pub(super) fn end(&mut self, why: Refused) -> Option<(u16, Result<(), Refused>)> {
        let ticket = self.ticket.take()?;
        // Where set-points go on all the same, it slows down by itself.
        self.sequence.cancel();
        let axis = why.axis.or(Some(self.sequence.axis() as u8));
        Some((ticket, Err(Refused { axis, ..why })))
    }

    /// The axes do not follow set-points any more, and are not known to be where they were.
    pub(super) fn forget(&mut self) {
        if !self.sequence.is_blank() {
            self.sequence = HomingSequence::NEW;
            SHARED.forget_origins();
        }
    }

    /// Whether the set-points are those of a homing.
    pub(super) const fn is_active(&self) -> bool {
        self.sequence.is_active()
    }

    /// Whether the axis may be there, in counts of its drive.
    pub(super) fn allows(&self, axis: usize, counts: i32) -> bool {
        self.sequence.allows(plans(), axis, counts)
    }

    /// The set-point of this cycle, while every axis follows; how it has ended, where a command waits for that.
    pub(super) fn cycle(
        &mut self,
        master: &mut BoardMaster,
        now: Instant,
    ) -> Option<(u16, Result<(), Refused>)> {
        let step = self.sequence.cycle(plans(), now.as_us(), |axis| {
            let snapshot = master.snapshot(axis)?;
            let mut inputs = Drives::readings(machine::axes().get(axis)?, &snapshot);
            let homing = plans().get(axis)?.as_ref()?;
            inputs.switch = homing.switch_pin.map(|pin| home::read_switch(pin, now));
            Some(inputs)
        });
        let result = match step? {
            HomingStep::Target(axis, counts) => {
                let error = master.set_target(axis, counts).err()?;
                defmt::error!("axis {=usize}: target refused, stopping: {}", axis, error);
                self.forget();
                master.stop(now, GROUP);
                Err(Reason::HomePlan.at(axis, 0, 0))
            }
            HomingStep::Found(axis, home) => {
                let origin = home.frame.origin_counts();
                defmt::info!(
                    "axis {=usize}: its reference is at {=i32} counts, within {=u32}, and its zero at {=i32}",
                    axis,
                    home.found_counts,
                    home.uncertainty_counts,
                    origin
                );
                SHARED.set_origin(axis, origin, home.uncertainty_counts);
                return None;
            }
            HomingStep::Ended(Ok(())) => Ok(()),
            HomingStep::Ended(Err((refused, abort))) => {
                if let Some(abort) = &abort {
                    home::write_abort(self.sequence.axis(), abort);
                }
                if refused.is(Reason::HomePlan) {
                    master.stop(now, GROUP);
                }
                Err(refused)
            }
        };
        Some((self.ticket.take()?, result))
    }
}
