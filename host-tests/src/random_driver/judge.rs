//! The judge: what must hold after every call, frame and event, by what drives and controller saw.

use can_motion::AxisState;

use super::books::{Books, OffWord, Permit};
use super::subject::{AXES, Asked, Rules, Seen, Told};

/// A drive that is so far off has arrived.
const DRIFT_TOLERANCE: u32 = 16;

/// The judge.
#[derive(Debug)]
pub(super) struct Judge {
    pub(super) rules: Rules,
    pub(super) books: [Books; AXES],
    /// Requests that the controller took in this cycle and did not give back.
    pub(super) requests: i32,
    pub(super) cycle: u64,
    begun_us: u64,
    pub(super) is_bus_off: bool,
    must_fault: [bool; AXES],
    /// What did not hold, first of all.
    pub(super) finding: Option<String>,
}

impl Judge {
    pub(super) fn new(rules: Rules) -> Self {
        Self {
            rules,
            books: [Books::NEW; AXES],
            requests: 0,
            cycle: 0,
            begun_us: 0,
            is_bus_off: false,
            must_fault: [false; AXES],
            finding: None,
        }
    }

    pub(super) fn broken(&mut self, axis: usize, what: impl Into<String>) {
        let what = what.into();
        self.finding.get_or_insert(format!("axis {axis}: {what}"));
    }

    pub(super) fn in_group(&self, group: u8) -> impl Iterator<Item = usize> + use<> {
        let groups = self.rules.groups;
        (0..AXES).filter(move |axis| groups[*axis] == group)
    }

    /// A cycle begins now; [`Self::has_begun`] follows when its events were read.
    pub(super) fn begins(&mut self, now_us: u64) {
        (self.requests, self.begun_us) = (0, now_us);
        self.cycle += 1;
        let Rules {
            stuck_us, reply_us, ..
        } = self.rules;
        for (books, must_fault) in self.books.iter_mut().zip(&mut self.must_fault) {
            books.asked = books.asked.filter(|(at, _)| now_us < at + reply_us);
            let is_stuck = books.set_point_us.is_some_and(|at| now_us - at >= stuck_us);
            *must_fault = is_stuck && books.permit == Permit::Stream;
        }
    }

    pub(super) fn has_begun(&mut self) {
        for axis in 0..AXES {
            if self.must_fault[axis] && !self.books[axis].is_latched {
                self.broken(axis, "an outage in motion is no fault");
            }
        }
    }

    /// Everything that was to be sent now is with the controller.
    pub(super) fn is_idle(&mut self) {
        let Rules {
            confirm_us,
            has_cycle_frames,
            ..
        } = self.rules;
        for axis in 0..AXES {
            let Some(word) = self.books[axis].off_word.filter(|word| word.is_due) else {
                continue;
            };
            let may_wait = has_cycle_frames && word.since_cycle == self.cycle;
            match word.taken_us {
                None if !may_wait => self.broken(axis, "the command to disable did not leave"),
                Some(_)
                    if word
                        .repeated_us
                        .is_none_or(|at| self.begun_us >= at + confirm_us) =>
                {
                    self.broken(axis, "the command to disable is not repeated");
                }
                _ => {}
            }
        }
    }

    /// A frame of a drive comes in.
    /// Whether it is an alarm that must stop the group.
    pub(super) fn delivers(
        &mut self,
        axis: usize,
        id: u16,
        told: Told,
        asked: Option<Asked>,
        now_us: u64,
    ) -> bool {
        let books = &mut self.books[axis];
        let counts = if self.rules.is_asked {
            // Answers do not say which request they are to (D31): a very late one passes for that to the latest.
            let open = books.asked.filter(|(_, open)| *open == id);
            books.asked = books.asked.filter(|(_, open)| *open != id);
            let is_behind_switches = asked.is_none_or(|asked| asked.is_behind_switches);
            open.map(|(taken_us, _)| Asked {
                taken_us,
                is_behind_switches,
            })
        } else {
            asked
        };
        let is_answer = counts.is_some() && !books.is_doubtful;
        let is_alarm = told.is_alarm && (asked.is_none() || is_answer);
        if told.is_boot_up {
            (books.is_mine, books.is_found) = (false, false);
            books.told_power = books.told_power.filter(|is_on| !is_on);
        }
        if is_alarm {
            books.is_mine &= !self.rules.alarm_frees_shaft;
            if !books.is_latched {
                books.told_power = None;
            }
            self.stop(self.rules.groups[axis], false);
        }
        if let Some(asked) = counts {
            Self::learn(&mut self.books[axis], told, asked, &self.rules, now_us);
        }
        is_alarm
    }

    fn learn(books: &mut Books, told: Told, asked: Asked, rules: &Rules, now_us: u64) {
        let cycle_us = rules.cycle_us;
        // What a drive reports by itself counts from when it came.
        let asked_us = if rules.has_cycle_frames {
            now_us
        } else {
            asked.taken_us
        };
        let is_newer = |at: Option<u64>| at.is_none_or(|at| asked.taken_us > at);
        match told.power {
            Some(true) => {
                // One asked for within a cycle of the command is not believed.
                if books
                    .switched_on_us
                    .is_none_or(|at| asked_us >= at + cycle_us)
                {
                    books.told_power = Some(true);
                }
                let is_closing = books.may_close || books.off_word.is_some();
                if !books.is_mine && !is_closing {
                    (books.is_found, books.closed_us) = (true, None);
                }
            }
            Some(false) if asked.is_behind_switches && is_newer(books.told_on_us) => {
                let is_confirmed = books
                    .off_word
                    .is_none_or(|word| !word.is_due || word.taken_us.is_some());
                // One asked for before or within a cycle of the command is not believed.
                let is_awaited = rules.has_cycle_frames
                    && books.may_close
                    && books.is_mine
                    && books.closed_us.is_none();
                let is_late = books.closed_us.is_none_or(|at| asked_us >= at + cycle_us);
                if is_confirmed && is_late && !is_awaited {
                    books.off_word = None;
                    books.may_close = false;
                    books.closed_us = None;
                    books.told_power = Some(false);
                    books.is_found = false;
                    // A report on the way to power, which goes by steps.
                    books.is_mine &= rules.has_cycle_frames && books.wants_power.is_some();
                }
            }
            _ => {}
        }
        let is_after_word = books.wants_power.is_some_and(|at| asked.taken_us >= at);
        match told.stands {
            Some(true) => books.stands |= is_after_word,
            Some(false) => (books.stands, books.is_located) = (false, false),
            None => {}
        }
        if let Some(position) = told.position {
            books.told_position = Some(position);
            books.is_located |= is_after_word && books.stands;
        }
    }

    /// The alarm of a drive was delivered, and the events were read.
    pub(super) fn has_alarmed(&mut self, axis: usize) {
        if !self.books[axis].is_latched {
            self.broken(axis, "an alarm is no fault");
        }
    }

    /// An event of an axis.
    pub(super) fn sees(&mut self, axis: usize, seen: Seen, now_us: u64) {
        match seen {
            Seen::Fault {
                is_own,
                ramps,
                ramps_itself,
                is_bus,
                disables,
            } => {
                let books = &mut self.books[axis];
                books.is_latched = true;
                if is_own {
                    books.stop(ramps_itself);
                    self.stop(self.rules.groups[axis], ramps);
                    for other in self.in_group(self.rules.groups[axis]) {
                        let books = &mut self.books[other];
                        books.may_close |= disables && !books.is_found;
                    }
                }
                if is_bus {
                    self.books[axis].told_power = None;
                    // With its contact the master forgets who switched the drive on, until it reports again.
                    self.books[axis].is_found = false;
                }
            }
            Seen::State {
                from,
                to,
                by_fault,
                is_back,
            } => self.sees_state(axis, (from, to), (by_fault, is_back), now_us),
            Seen::Other => {}
        }
        self.note_rest();
    }

    fn sees_state(
        &mut self,
        axis: usize,
        (from, to): (AxisState, AxisState),
        (by_fault, is_back): (bool, bool),
        now_us: u64,
    ) {
        let books = &mut self.books[axis];
        if by_fault && !books.is_latched {
            self.broken(axis, format!("{to} by a fault that no event names"));
            return;
        }
        if matches!(
            to,
            AxisState::Probing | AxisState::AwaitingStandstill | AxisState::Anchoring
        ) {
            // It is located anew, perhaps before the end of this cycle.
            books.offset = None;
        }
        match (from, to) {
            (_, AxisState::AwaitingStandstill) => books.awaits_us = now_us,
            (_, AxisState::Streaming) if books.permit == Permit::Stream => {
                books.set_point_us = Some(now_us);
            }
            (_, AxisState::Streaming) => self.broken(axis, "streams without a word"),
            (
                AxisState::DriveMoving | AxisState::DriveStopping | AxisState::Loaded,
                AxisState::DriveMoving | AxisState::DriveStopping | AxisState::Loaded,
            ) => {}
            // Its frame came back, and goes out again.
            (AxisState::Loaded | AxisState::DriveMoving, AxisState::Holding)
                if is_back && books.own.is_some_and(|own| !own.is_stopping) => {}
            (AxisState::Loaded, _) => books.own = None,
            (AxisState::DriveMoving | AxisState::DriveStopping, _) => {
                // Where it is now is where its drive said that it is, unless it never heard of the motion.
                let has_heard = books.own.take().is_some_and(|own| own.is_sent);
                if has_heard {
                    books.offset = None;
                }
                books.has_arrived |= has_heard;
            }
            // Loaded before the fault, and cleared.
            (AxisState::Faulted, AxisState::Loaded) => {}
            (_, AxisState::DriveMoving | AxisState::DriveStopping | AxisState::Loaded)
                if books.own.is_none() =>
            {
                self.broken(axis, format!("{to} without a word"));
            }
            (AxisState::RampingDown, _) => {
                books.permit = Permit::Rest;
                if self.rules.is_speed {
                    // A frame without speed that comes back is owed again before any other.
                    (books.ledger, books.before) = (0, [0; 4]);
                }
            }
            (AxisState::Disabling, AxisState::Ready)
                if books.off_word.is_some_and(|word| word.taken_us.is_some()) =>
            {
                self.broken(axis, "ready, and the drive did not confirm that it is off");
            }
            _ => {}
        }
    }

    /// A word to switch off is due as soon as its axis rests.
    fn note_rest(&mut self) {
        for books in &mut self.books {
            let rests = books.permit == Permit::Rest && books.own.is_none();
            if let Some(word) = books.off_word.as_mut().filter(|word| rests && !word.is_due) {
                (word.is_due, word.since_cycle) = (true, self.cycle);
            }
        }
    }

    pub(super) fn stop(&mut self, group: u8, ramps: bool) {
        for axis in self.in_group(group) {
            self.books[axis].stop(ramps);
        }
        self.note_rest();
    }

    // The calls of the application, each when it was accepted.

    pub(super) fn enabled(&mut self, group: u8, now_us: u64) {
        for axis in self.in_group(group) {
            self.books[axis].permit = Permit::Stream;
            self.books[axis].set_point_us = None;
            self.books[axis].wants_power_at(now_us);
            self.books[axis].doubt_question();
        }
    }

    pub(super) fn resumed(&mut self, group: u8, now_us: u64) {
        let may_rearm = self.rules.has_cycle_frames;
        for axis in self.in_group(group) {
            let books = &mut self.books[axis];
            books.permit = Permit::Stream;
            books.set_point_us = None;
            if may_rearm {
                books.wants_power_at(now_us);
            }
        }
    }

    /// The drives of the group that the master had found on.
    pub(super) fn adopted(&mut self, group: u8, found: [bool; AXES]) {
        for axis in self.in_group(group) {
            let books = &mut self.books[axis];
            if found[axis] {
                (books.is_mine, books.is_found) = (true, false);
                books.told_power = Some(true);
                (books.off_word, books.may_close) = (None, false);
                books.doubt_question();
            }
        }
    }

    pub(super) fn disabled(&mut self, group: u8) {
        self.stop(group, true);
        for axis in self.in_group(group) {
            let cycle = self.cycle;
            let books = &mut self.books[axis];
            books.is_found = false;
            if books.told_power != Some(false) && books.off_word.is_none() {
                books.off_word = Some(OffWord {
                    is_due: false,
                    since_cycle: cycle,
                    taken_us: books.closed_us,
                    repeated_us: books.closed_us,
                });
            }
        }
        self.note_rest();
    }

    pub(super) fn cleared(&mut self, group: u8) {
        for axis in self.in_group(group) {
            self.books[axis].is_latched = false;
            self.books[axis].doubt_question();
        }
    }

    pub(super) fn bus_off(&mut self) {
        self.is_bus_off = true;
        for books in &mut self.books {
            books.stop(false);
            books.asked = None;
        }
        self.note_rest();
    }

    /// What the master believes to have sent, while it knows its position.
    pub(super) fn compares(&mut self, axis: usize, sent: Option<i32>) -> bool {
        let is_absolute = self.rules.is_absolute;
        let books = &mut self.books[axis];
        let Some(sent) = sent else {
            books.offset = None;
            return false;
        };
        match books.offset {
            Some(offset) if i64::from(sent) != offset + books.ledger => {
                let ledger = offset + books.ledger;
                self.broken(axis, format!("sent {sent}, the controller took {ledger}"));
                false
            }
            Some(_) => false,
            None => {
                if is_absolute && books.ledger != i64::from(sent) {
                    books.ledger = i64::from(sent);
                    books.before = [books.ledger; 4];
                }
                books.offset = Some(i64::from(sent) - books.ledger);
                let is_speed = self.rules.is_speed;
                let is_exact = books.told_position == Some(sent);
                if std::mem::take(&mut books.has_arrived) && !is_exact {
                    let off = books.told_position.map(|told| told.abs_diff(sent));
                    if off.is_none_or(|off| off > DRIFT_TOLERANCE) {
                        self.broken(axis, format!("arrived at {sent}, {off:?} counts off"));
                    }
                    return false;
                }
                if !is_speed && !is_exact {
                    let told = books.told_position;
                    self.broken(axis, format!("anchored at {sent}, the drive told {told:?}"));
                }
                true
            }
        }
    }
}
