//! What the judge says to a frame that the controller took or gave back.

use super::books::Permit;
use super::judge::Judge;
use super::subject::{Command, Rules};

impl Judge {
    /// The controller took a frame of an axis; `is_sure` when it did not report an error.
    pub(super) fn takes(
        &mut self,
        axis: usize,
        (id, command): (u16, Command),
        now_us: u64,
        is_sure: bool,
    ) {
        self.expects_disable_first(axis, command);
        let books = &self.books[axis];
        let touches = !matches!(command, Command::Ask | Command::Change | Command::Nothing);
        if books.is_found && touches {
            self.broken(axis, format!("{command:?} to a drive that was found on"));
        }
        match command {
            Command::Step(_) | Command::Target(_) => self.set_point(axis, command, now_us, is_sure),
            Command::Hold => self.holds(axis, now_us),
            Command::Brake => {
                if self.rules.is_speed {
                    self.books[axis].takes_value(0);
                }
            }
            Command::BrakeAsked => self.counts_request(axis),
            Command::On => self.switches_on(axis, now_us),
            Command::Off | Command::OffInCycle => self.switches_off(axis, command, now_us),
            Command::Ask => {
                self.counts_request(axis);
                self.asks(axis, id, now_us);
            }
            Command::Change => {
                self.counts_request(axis);
                self.changes(axis);
            }
            Command::Go(_) | Command::GoBy(_) | Command::Load(_) | Command::LoadBy(_) => {
                self.counts_request(axis);
                self.goes(axis, command);
            }
            Command::Trigger | Command::Nothing => {}
        }
    }

    fn expects_disable_first(&mut self, axis: usize, command: Command) {
        let waits = |books: &super::books::Books| {
            books
                .off_word
                .is_some_and(|word| word.is_due && word.taken_us.is_none())
        };
        let is_late = command != Command::Off && self.books.iter().any(waits);
        if is_late && !self.rules.has_cycle_frames {
            self.broken(axis, format!("{command:?} before a command to disable"));
        }
    }

    fn set_point(&mut self, axis: usize, command: Command, now_us: u64, is_sure: bool) {
        let limits = self.rules.axes[axis];
        let books = &mut self.books[axis];
        let (value, step) = match command {
            Command::Step(step) => (books.ledger + i64::from(step), i64::from(step)),
            Command::Target(value) => (i64::from(value), i64::from(value) - books.ledger),
            _ => return,
        };
        books.takes_value(value);
        let place = value + books.offset.unwrap_or(0);
        if let Permit::Ramp { set_points, .. } = &mut books.permit {
            *set_points += 1;
        }
        if is_sure {
            books.set_point_us = Some(now_us);
        }
        let (permit, is_anchored) = (books.permit, books.offset.is_some());
        if step.abs() > i64::from(limits.max_step) {
            self.broken(
                axis,
                format!("a step of {step}, at most {}", limits.max_step),
            );
        }
        if !is_anchored && !self.rules.is_speed {
            self.broken(axis, "a set-point without an anchor");
        }
        if place < i64::from(limits.min) || place > i64::from(limits.max) {
            self.broken(
                axis,
                format!("{place} is outside {}..={}", limits.min, limits.max),
            );
        }
        match permit {
            Permit::Stream => {}
            Permit::Rest => self.broken(axis, "a set-point without a word"),
            Permit::Ramp { from, set_points } => self.ramps(axis, value, from, set_points),
        }
    }

    fn ramps(&mut self, axis: usize, value: i64, from: i64, set_points: i32) {
        let limits = self.rules.axes[axis];
        let cycles = self
            .rules
            .axes
            .iter()
            .map(|axis| axis.ramp_cycles)
            .max()
            .unwrap_or(0);
        let way = if self.rules.is_speed {
            value.abs() - from.abs()
        } else {
            (value - from).abs()
        };
        let most = if self.rules.is_speed {
            0
        } else {
            i64::from(limits.max_step) * (i64::from(cycles) + 3) / 2
        };
        if way > most {
            self.broken(
                axis,
                format!("a ramp that goes on for {way}, at most {most}"),
            );
        }
        if set_points > 8 * cycles + 200 {
            self.broken(axis, "a ramp without end");
        }
    }

    /// A frame that keeps a drive on.
    fn holds(&mut self, axis: usize, now_us: u64) {
        let books = &mut self.books[axis];
        if self.rules.is_speed {
            books.takes_value(0);
        }
        books.set_point_us = books.set_point_us.map(|_| now_us);
        if !(books.is_mine && books.told_power == Some(true)) {
            self.switches_on(axis, now_us);
        }
    }

    fn switches_on(&mut self, axis: usize, now_us: u64) {
        let Rules {
            anchors_after_enable,
            standstill_us,
            ..
        } = self.rules;
        let books = &mut self.books[axis];
        let is_read = books.stands && books.is_located;
        let wants = books.wants_power;
        let is_latched = books.is_latched;
        let awaits_us = books.awaits_us;
        books.told_on_us = Some(now_us);
        let was_mine = std::mem::replace(&mut books.is_mine, true);
        books.told_before_on = books.told_power;
        books.told_power = books.told_power.filter(|is_on| *is_on);
        books.closed_us = None;
        if !was_mine || !self.rules.has_cycle_frames {
            books.switched_on_us = Some(now_us);
        }
        match wants {
            None => self.broken(axis, "switched on without a word"),
            Some(_) if is_latched => self.broken(axis, "switched on under a fault"),
            Some(at)
                if anchors_after_enable
                    && (!is_read || now_us < at.max(awaits_us) + standstill_us) =>
            {
                self.broken(axis, "switched on before standstill and position were read");
            }
            Some(_) => {}
        }
    }

    fn switches_off(&mut self, axis: usize, command: Command, now_us: u64) {
        let books = &mut self.books[axis];
        let is_own = books.is_mine && books.told_power == Some(true);
        let may = books.may_close || books.off_word.is_some();
        // A step on the way to power may lead through none.
        let may = may || self.rules.has_cycle_frames && books.wants_power.is_some();
        if books.told_power != Some(false) || books.is_mine {
            // A command in every cycle is one command.
            let is_one = self.rules.has_cycle_frames;
            books.closed_us = books.closed_us.filter(|_| is_one).or(Some(now_us));
        }
        if let Some(word) = &mut books.off_word {
            word.taken_us.get_or_insert(now_us);
            word.repeated_us = Some(now_us);
        }
        if command == Command::OffInCycle {
            self.books[axis].takes_value(0);
        }
        if is_own && !may {
            self.broken(axis, "switched off without a word");
        }
    }

    fn counts_request(&mut self, axis: usize) {
        self.requests += 1;
        if self.requests > self.rules.requests_per_cycle {
            self.broken(axis, format!("{} requests in a cycle", self.requests));
        }
    }

    fn asks(&mut self, axis: usize, id: u16, now_us: u64) {
        self.books[axis].is_doubtful = false;
        let open = self.books[axis].asked.replace((now_us, id));
        if let Some((at_us, _)) = open.filter(|_| self.rules.asks_one_at_a_time) {
            self.broken(
                axis,
                format!("asked again, the request of {at_us} us is open"),
            );
        }
    }

    fn changes(&mut self, axis: usize) {
        let books = &self.books[axis];
        if books.told_power != Some(false) || books.wants_power.is_some() {
            self.broken(axis, "a write to a drive that may have power");
        }
    }

    /// The controller gave a frame back unsent.
    pub(super) fn gives_back(&mut self, axis: usize, command: Command) {
        let books = &mut self.books[axis];
        match command {
            Command::Step(step) => {
                books.ledger -= i64::from(step);
                if let Some(own) = &mut books.own {
                    own.begins_elsewhere(i64::from(step));
                }
            }
            Command::Target(_) => books.gives_value_back(),
            Command::Hold | Command::Brake if self.rules.is_speed => books.gives_value_back(),
            Command::Go(_) | Command::GoBy(_) | Command::Load(_) | Command::LoadBy(_) => {
                self.goes_back(axis, command);
            }
            Command::BrakeAsked => self.requests -= 1,
            Command::Ask | Command::Change => {
                books.asked = None;
                self.requests -= 1;
            }
            // The next frame of a cycle says it again.
            Command::OffInCycle => books.gives_value_back(),
            Command::On if !self.rules.has_cycle_frames => {
                books.told_power = books.told_power.or(books.told_before_on);
            }
            Command::Off => {
                // To the master of wheels it may have been a request: the reset of a fault ends with the same write.
                self.requests -= i32::from(self.rules.has_cycle_frames);
                books.closed_us = None;
                // An answer from between may have passed for its confirmation.
                books.may_close |= books.off_word.is_none();
                if let Some(word) = &mut books.off_word {
                    (word.taken_us, word.since_cycle) = (None, self.cycle);
                }
            }
            _ => {}
        }
    }
}
