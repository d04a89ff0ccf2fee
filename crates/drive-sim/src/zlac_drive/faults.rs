//! Faults of a drive, on command of a test.
//!
//! Specification: a drive does none of this by itself. What changes the drive takes effect when its bench runs next; what changes replies concerns
//! the next ones that are prepared.

use super::config::ZlacSurroundings;

/// What changes the drive itself.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Action {
    Fault(u16),
    FaultGone,
    PowerCycle { off_ns: u64 },
    EmergencyInput(bool),
    Surroundings(ZlacSurroundings),
}

/// How one SDO reply is spoilt.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum ReplyDamage {
    /// Not sent.
    Drop,
    /// Later by so many nanoseconds.
    Delay(u64),
    /// Sent twice.
    Duplicate,
    /// The index is one too high.
    WrongIndex,
    /// The sub-index is one too high.
    WrongSub,
    /// The last four bytes are missing.
    Short,
}

/// Control panel for the faults of one drive.
#[derive(Debug, Clone, Default)]
pub struct ZlacFaults {
    actions: Vec<Action>,
    deaf: bool,
    mute: bool,
    damage: Vec<ReplyDamage>,
    /// Writes that are still confirmed.
    writes_left: Option<u64>,
}

impl ZlacFaults {
    /// The drive trips with these bits of 603Fh, and the cause stays until [`Self::remove_cause`].
    pub fn trip(&mut self, fault_bits: u16) {
        self.actions.push(Action::Fault(fault_bits));
    }

    /// The cause of the fault is gone; the drive still waits for its reset.
    pub fn remove_cause(&mut self) {
        self.actions.push(Action::FaultGone);
    }

    /// The power goes away for `off_ns` and comes back; the boot delay follows.
    pub fn power_cycle(&mut self, off_ns: u64) {
        self.actions.push(Action::PowerCycle { off_ns });
    }

    /// Somebody presses or releases the button at an emergency stop input.
    pub fn emergency_input(&mut self, active: bool) {
        self.actions.push(Action::EmergencyInput(active));
    }

    /// Temperatures and voltage are others from now on.
    pub fn surroundings(&mut self, surroundings: ZlacSurroundings) {
        self.actions.push(Action::Surroundings(surroundings));
    }

    /// After so many SDO writes the drive neither obeys nor sends any more, as with a cable that breaks meanwhile.
    pub fn fall_silent_after_writes(&mut self, writes: u64) {
        self.writes_left = Some(writes);
    }

    /// An SDO write has come; tells whether the drive is there for it.
    pub(super) fn takes_write(&mut self) -> bool {
        match &mut self.writes_left {
            None => true,
            Some(0) => {
                self.leave_bus();
                false
            }
            Some(left) => {
                *left -= 1;
                true
            }
        }
    }

    /// From now on nothing is sent and nothing is heard, as with a broken cable; what moves goes on.
    pub fn leave_bus(&mut self) {
        (self.deaf, self.mute) = (true, true);
    }

    /// From now on nothing is sent; requests are heard and obeyed.
    pub fn fall_silent(&mut self) {
        self.mute = true;
    }

    /// Ends [`Self::leave_bus`] and [`Self::fall_silent`].
    pub fn wake(&mut self) {
        (self.deaf, self.mute) = (false, false);
    }

    /// Spoils the next SDO reply; several wait for one reply each.
    pub fn damage_next_reply(&mut self, damage: ReplyDamage) {
        self.damage.push(damage);
    }

    pub(super) fn has_actions(&self) -> bool {
        !self.actions.is_empty()
    }

    pub(super) fn take_actions(&mut self) -> Vec<Action> {
        core::mem::take(&mut self.actions)
    }

    pub(super) fn hears(&self) -> bool {
        !self.deaf
    }

    pub(super) fn sends(&self) -> bool {
        !self.mute
    }

    pub(super) fn next_damage(&mut self) -> Option<ReplyDamage> {
        (!self.damage.is_empty()).then(|| self.damage.remove(0))
    }
}
