//! What the judge says to motions that drives make by themselves.

use super::books::OwnMove;
use super::judge::Judge;
use super::subject::{AXES, Command};

impl Judge {
    /// The master took the word for a motion from `start` to `end`.
    pub(super) fn asked_to_move(
        &mut self,
        axis: usize,
        (start, end): (i32, i32),
        (is_relative, by_trigger): (bool, bool),
    ) {
        let limits = self.rules.axes[axis];
        if end < limits.min || end > limits.max {
            self.broken(axis, format!("a move to {end} was taken"));
        }
        self.books[axis].own = Some(OwnMove {
            start: start.into(),
            end: end.into(),
            is_relative,
            by_trigger,
            is_sent: false,
            is_triggered: false,
            is_stopping: false,
            stops: 0,
        });
    }

    /// The controller took a frame about a motion of one drive.
    pub(super) fn goes(&mut self, axis: usize, command: Command) {
        let Some(own) = &mut self.books[axis].own else {
            self.broken(axis, format!("{command:?} without a word"));
            return;
        };
        let distance = own.end - own.start;
        let begins = match command {
            Command::Go(end) => {
                (i64::from(end), false, false) == (own.end, own.is_relative, own.by_trigger)
            }
            Command::GoBy(by) => {
                (i64::from(by), true, false) == (distance, own.is_relative, own.by_trigger)
            }
            Command::Load(end) => {
                (i64::from(end), false, true) == (own.end, own.is_relative, own.by_trigger)
            }
            Command::LoadBy(by) => {
                (i64::from(by), true, true) == (distance, own.is_relative, own.by_trigger)
            }
            _ => false,
        };
        let is_on_the_way =
            |place: i64| (own.start.min(own.end)..=own.start.max(own.end)).contains(&place);
        let stops = match command {
            Command::Go(place) => own.is_stopping && is_on_the_way(place.into()),
            _ => false,
        };
        let is_meant = if own.is_stopping || own.is_sent {
            stops
        } else {
            begins
        };
        own.stops += u32::from(own.is_stopping);
        own.is_sent = true;
        let own = *own;
        if !is_meant {
            self.broken(axis, format!("{command:?} for {own:?}"));
        }
    }

    /// The controller gave a frame about a motion of one drive back.
    pub(super) fn goes_back(&mut self, axis: usize, command: Command) {
        self.requests -= 1;
        let Some(own) = &mut self.books[axis].own else {
            return;
        };
        if matches!(command, Command::Go(_)) && own.stops > 0 {
            own.stops -= 1;
        } else if own.stops > 0 {
            // The drive never heard of the motion, only of its stop: it is to stay where it was.
            own.end = own.start;
        } else {
            own.is_sent = false;
        }
    }

    /// The controller took a trigger; `holds_loads` when frames that load a move wait behind it.
    pub(super) fn triggers(&mut self, holds_loads: bool) {
        self.requests += 1;
        if self.requests > self.rules.requests_per_cycle {
            self.broken(0, "a trigger beyond the requests of a cycle");
        }
        if holds_loads {
            self.broken(0, "a trigger before its moves have left");
        }
        for axis in 0..AXES {
            let books = &mut self.books[axis];
            let own = books
                .own
                .as_mut()
                .filter(|own| own.by_trigger && own.is_sent && !own.is_stopping);
            let is_meant = own.is_some();
            if let Some(own) = own {
                own.is_triggered = true;
            }
            // What is off starts nothing, as far as the master can know.
            books.may_start = is_meant || books.told_power == Some(false);
        }
    }

    /// The controller gave the trigger back.
    pub(super) fn trigger_comes_back(&mut self) {
        self.requests -= 1;
        for books in &mut self.books {
            if let Some(own) = &mut books.own {
                own.is_triggered = false;
            }
        }
    }

    /// A trigger started this drive.
    pub(super) fn started(&mut self, axis: usize) {
        if !self.books[axis].may_start {
            self.broken(axis, "a trigger started what nobody asked for");
        }
    }
}
