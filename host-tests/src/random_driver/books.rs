//! What the judge knows of one axis: from the calls, the frames that the controller took, and the answers that came in time.

/// Which set-points an axis may get.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Permit {
    /// None.
    Rest,
    /// Those of a ramp, which began at this value of the ledger.
    Ramp { from: i64, set_points: i32 },
    /// Any within the limits.
    Stream,
}

/// A motion that the drive was asked to make by itself, until its axis says that it is over.
#[derive(Debug, Clone, Copy)]
pub(super) struct OwnMove {
    pub(super) start: i64,
    pub(super) end: i64,
    pub(super) is_relative: bool,
    pub(super) by_trigger: bool,
    /// The controller took its frame.
    pub(super) is_sent: bool,
    /// The controller took its trigger.
    pub(super) is_triggered: bool,
    pub(super) is_stopping: bool,
    /// Commands to stop that the controller took and did not give back.
    pub(super) stops: u32,
}

impl OwnMove {
    /// A set-point from before it came back: it begins elsewhere, and ends elsewhere when its drive was told by how much to move.
    pub(super) fn begins_elsewhere(&mut self, unsent: i64) {
        self.start -= unsent;
        if self.is_relative && self.is_sent {
            self.end -= unsent;
        }
    }
}

/// The word to switch off, until the drive confirmed it.
#[derive(Debug, Clone, Copy)]
pub(super) struct OffWord {
    /// The axis is at rest: the command is due.
    pub(super) is_due: bool,
    /// Cycle in which it became due.
    pub(super) since_cycle: u64,
    /// When the controller took the command first.
    pub(super) taken_us: Option<u64>,
    /// And last.
    pub(super) repeated_us: Option<u64>,
}

/// The books of one axis.
#[derive(Debug, Clone, Copy)]
pub(super) struct Books {
    pub(super) permit: Permit,
    pub(super) own: Option<OwnMove>,
    /// It ended where it was told to go, as far as the drift tolerance tells.
    pub(super) has_arrived: bool,
    /// The trigger that the controller took may start the drive.
    pub(super) may_start: bool,
    /// When power was asked for, until that is over.
    pub(super) wants_power: Option<u64>,
    pub(super) is_latched: bool,
    /// The latest report of the drive about its power that counts.
    pub(super) told_power: Option<bool>,
    /// The same before the command to switch on that may still come back: then the drive never heard it.
    pub(super) told_before_on: Option<bool>,
    /// This master switched the drive on, or adopted it.
    pub(super) is_mine: bool,
    /// The drive reported power that this master did not give.
    pub(super) is_found: bool,
    pub(super) off_word: Option<OffWord>,
    /// The master may switch off on its own account: enabling was cut short, or the reaction to a fault says so.
    pub(super) may_close: bool,
    /// When the controller took the latest command to switch off, until it is confirmed.
    pub(super) closed_us: Option<u64>,
    /// When the controller took the first command to switch on since the drive was off, and the latest.
    pub(super) switched_on_us: Option<u64>,
    pub(super) told_on_us: Option<u64>,
    /// The request that is under way: when the controller took it, and its identifier.
    pub(super) asked: Option<(u64, u16)>,
    /// The master may not take the answer to that request for one.
    pub(super) is_doubtful: bool,
    pub(super) set_point_us: Option<u64>,
    /// What the controller took and did not give back: the sum of steps, or the latest value.
    pub(super) ledger: i64,
    /// Values before the latest ones, for those that are given back.
    pub(super) before: [i64; 4],
    /// Sent position of the master minus the ledger, while it is anchored.
    pub(super) offset: Option<i64>,
    /// The latest position that was told in time.
    pub(super) told_position: Option<i32>,
    /// Since when the axis waits for a shaft that stands.
    pub(super) awaits_us: u64,
    /// A reading of a standing shaft that was asked for after the word to enable.
    pub(super) stands: bool,
    /// A position that was read behind it.
    pub(super) is_located: bool,
}

impl Books {
    pub(super) const NEW: Self = Self {
        permit: Permit::Rest,
        own: None,
        has_arrived: false,
        may_start: false,
        wants_power: None,
        is_latched: false,
        told_power: None,
        told_before_on: None,
        is_mine: false,
        is_found: false,
        off_word: None,
        may_close: false,
        closed_us: None,
        switched_on_us: None,
        told_on_us: None,
        asked: None,
        is_doubtful: false,
        set_point_us: None,
        ledger: 0,
        before: [0; 4],
        offset: None,
        told_position: None,
        awaits_us: 0,
        stands: false,
        is_located: false,
    };

    /// No set-points any more, or only those of a ramp.
    pub(super) fn stop(&mut self, ramps: bool) {
        self.permit = match self.permit {
            Permit::Stream if ramps => Permit::Ramp {
                from: self.ledger,
                set_points: 0,
            },
            ramp @ Permit::Ramp { .. } if ramps => ramp,
            _ => Permit::Rest,
        };
        self.own = self.own.filter(|own| own.is_sent);
        if let Some(own) = &mut self.own {
            own.is_stopping = true;
        }
        if self.permit == Permit::Rest {
            self.set_point_us = None;
        }
        // What was not on yet may be switched off again.
        self.may_close |= self.wants_power.is_some() && self.told_power != Some(true);
        self.wants_power = None;
    }

    /// The master may start to ask anew: what it asked before may not be awaited any more.
    pub(super) fn doubt_question(&mut self) {
        self.is_doubtful = true;
    }

    pub(super) fn wants_power_at(&mut self, now_us: u64) {
        self.wants_power = Some(now_us);
        (self.stands, self.is_located) = (false, false);
        self.off_word = None;
    }

    pub(super) fn takes_value(&mut self, value: i64) {
        self.before.rotate_right(1);
        self.before[0] = self.ledger;
        self.ledger = value;
    }

    pub(super) fn gives_value_back(&mut self) {
        self.ledger = self.before[0];
        self.before.rotate_left(1);
    }
}
