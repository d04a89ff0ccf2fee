//! Motions that drives make by themselves: which axes may be told, and which start together.

use bus_user::Instant;

use crate::core::axis::Change;
use crate::core::command::{CommandError, MoveError};
use crate::core::drive_move::DriveMove;
use crate::core::exit::{Class, may_leave};
use crate::core::facts::{Facts, Goal, Motion};
use crate::core::family::{Drive, Family, GroupId};
use crate::core::group::Axes;
use crate::core::step::{Input, accepts};

/// A move that a trigger is to start, and that has not started.
const fn awaits_trigger(facts: &Facts) -> bool {
    matches!(facts.goal, Goal::SyncMove) && !matches!(facts.motion, Motion::DriveMove)
}

impl<const N: usize, F: Family> Axes<N, F> {
    pub(crate) fn start_move(
        &mut self,
        (now, config): (Instant, &F::Config),
        index: usize,
        wanted: DriveMove,
    ) -> Result<(), MoveError<F::Fault>> {
        self.admit_move((now, config), index, wanted, Input::Move)?;
        self.begin_move((now, config), index, wanted, Input::Move);
        Ok(())
    }

    pub(crate) fn start_moves(
        &mut self,
        (now, config): (Instant, &F::Config),
        moves: &[(usize, DriveMove)],
    ) -> Result<(), MoveError<F::Fault>> {
        let concerned = self.admit_moves((now, config), moves)?;
        for other in 0..self.len() {
            if concerned & 1 << other == 0 && self.would_start(other, moves) {
                return Err(MoveError::OldLoad { axis: other as u8 });
            }
        }
        for &(index, wanted) in moves {
            self.begin_move((now, config), index, wanted, Input::SyncMove);
        }
        Ok(())
    }

    /// One bit for each axis, when each of them can make its move and they belong together.
    fn admit_moves(
        &self,
        (now, config): (Instant, &F::Config),
        moves: &[(usize, DriveMove)],
    ) -> Result<u64, MoveError<F::Fault>> {
        let mut concerned: u64 = 0;
        let mut group: Option<GroupId> = None;
        let (_, first) = *moves.first().ok_or(MoveError::NotTogether)?;
        for &(index, wanted) in moves {
            self.admit_move((now, config), index, wanted, Input::SyncMove)?;
            let own = self.get(index).map(|axis| axis.drive.group());
            let is_of_kind = matches!(
                (first, wanted),
                (DriveMove::To(_), DriveMove::To(_)) | (DriveMove::By(_), DriveMove::By(_))
            );
            let is_in_group = group.is_none() || group == own;
            if !is_of_kind || !is_in_group || concerned & 1 << index != 0 {
                return Err(MoveError::NotTogether);
            }
            concerned |= 1 << index;
            group = own;
        }
        Ok(concerned)
    }

    fn admit_move(
        &self,
        (now, config): (Instant, &F::Config),
        index: usize,
        wanted: DriveMove,
        input: Input,
    ) -> Result<(), MoveError<F::Fault>> {
        let axes = self.len();
        let axis = self.get(index).ok_or(MoveError::NoSuchAxis {
            axes,
            actual: index,
        })?;
        self.admit(index, axis, input)?;
        self.admit_group(axis.drive.group())?;
        let by_trigger = input == Input::SyncMove;
        let admitted = axis.drive.admit_move(wanted, by_trigger, config, now);
        admitted.map_err(|refusal| MoveError::Refused {
            axis: index as u8,
            refusal,
        })
    }

    /// Nothing of a group moves while one of its axes has a fault.
    fn admit_group(&self, group: GroupId) -> Result<(), CommandError<F::Fault>> {
        let mut faults = self
            .iter()
            .enumerate()
            .filter(|(_, axis)| axis.drive.group() == group)
            .filter_map(|(index, axis)| Some((index, axis.fault()?)));
        match faults.next() {
            Some((index, fault)) => Err(CommandError::Faulted {
                axis: index as u8,
                fault,
            }),
            None => Ok(()),
        }
    }

    fn begin_move(
        &mut self,
        (now, config): (Instant, &F::Config),
        index: usize,
        wanted: DriveMove,
        input: Input,
    ) {
        if let Some(axis) = self.get_mut(index) {
            axis.drive.begin_move(wanted, config);
        }
        self.apply(now, index, Change::of(input));
    }

    /// Whether a trigger for these moves could start something in the drive of an axis that is not one of them. A drive without power
    /// starts nothing.
    fn would_start(&self, index: usize, moves: &[(usize, DriveMove)]) -> bool {
        let (Some(axis), Some(&(_, kind))) = (self.get(index), moves.first()) else {
            return false;
        };
        let facts = &axis.view.facts;
        let may_hold = axis.drive.may_hold_load(kind)
            || awaits_trigger(facts)
            || matches!(facts.motion, Motion::Loaded | Motion::Armed);
        may_hold && facts.power.may_be_on()
    }

    /// The drive of an axis answered since its move was loaded: when all that are to start with it have, the trigger may go out.
    pub(crate) fn arm(&mut self, now: Instant, index: usize) {
        let Some(group) = self.get(index).map(|axis| axis.drive.group()) else {
            return;
        };
        let mut waiting = self
            .iter()
            .filter(|axis| axis.drive.group() == group && awaits_trigger(&axis.view.facts));
        let are_seen =
            waiting.all(|axis| accepts(&axis.view.facts, Input::Arm) && axis.drive.has_seen_load());
        drop(waiting);
        if are_seen {
            for index in 0..self.len() {
                if self.is_in(index, group) {
                    self.apply(now, index, Change::of(Input::Arm));
                }
            }
        }
    }

    /// Whether the trigger of the group of an axis starts what is asked for and nothing else.
    pub(crate) fn may_be_triggered(&self, index: usize) -> bool {
        let Some((group, kind)) = self
            .get(index)
            .and_then(|axis| Some((axis.drive.group(), axis.drive.loaded_move()?)))
        else {
            return false;
        };
        let moves = [(index, kind)];
        self.iter().enumerate().all(|(other, axis)| {
            let is_meant = axis.drive.group() == group && awaits_trigger(&axis.view.facts);
            if is_meant {
                may_leave(Class::Trigger, &axis.view.facts)
            } else {
                !self.would_start(other, &moves)
            }
        })
    }

    /// The controller accepted the trigger of the group of an axis.
    pub(crate) fn trigger_accepted(&mut self, now: Instant, index: usize) {
        let Some(group) = self.get(index).map(|axis| axis.drive.group()) else {
            return;
        };
        self.triggered = 0;
        for other in 0..self.len() {
            let is_armed = |facts: &Facts| may_leave(Class::Trigger, facts);
            if self.is_in(other, group)
                && self
                    .get(other)
                    .is_some_and(|axis| is_armed(&axis.view.facts))
            {
                self.triggered |= 1 << other;
                self.apply(now, other, Change::of(Input::Accepted(Class::Trigger)));
            }
        }
    }

    /// The controller gave the trigger back unsent.
    pub(crate) fn trigger_returned(&mut self, now: Instant) {
        for index in 0..self.len() {
            if self.triggered & 1 << index != 0 {
                self.apply(now, index, Change::of(Input::Displaced(Class::Trigger)));
            }
        }
        self.triggered = 0;
    }
}
