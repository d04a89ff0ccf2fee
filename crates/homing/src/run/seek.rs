//! The ways to a hard stop and to a switch.

use super::settle::Settling;
use super::{Found, Homing, Phase};
use crate::abort::Abort;
use crate::config::{HardStop, Switch};
use crate::inputs::Inputs;

impl Homing {
    pub(super) fn seek_stop(
        &mut self,
        stop: &HardStop,
        now_us: u64,
        inputs: &Inputs,
    ) -> Result<(), Abort> {
        let position = inputs
            .position
            .map_or(self.start_counts, |position| position.value);
        match self.phase {
            Phase::Search(settling) => {
                if self.witness.is_in_contact(stop, inputs)? {
                    return self.retreat(position);
                }
                self.search_on(settling, now_us)
            }
            Phase::Retreat(from, mut settling) => {
                if !self.is_free(stop, &mut settling, now_us, inputs)? {
                    self.phase = Phase::Retreat(from, settling);
                    return Ok(());
                }
                self.again(from, self.ahead(from, stop.most_counts))
            }
            Phase::Again(from, settling) => {
                if self.witness.is_in_contact(stop, inputs)? {
                    return self.judge_contacts(stop, from, position, inputs);
                }
                self.again_on(stop.repeat_counts, from, settling, now_us)
            }
            Phase::Part(found, mut settling) => {
                if self.is_free(stop, &mut settling, now_us, inputs)? {
                    return self.finish(found);
                }
                self.phase = Phase::Part(found, settling);
                Ok(())
            }
            _ => Ok(()),
        }
    }

    fn judge_contacts(
        &mut self,
        stop: &HardStop,
        first: i32,
        second: i32,
        inputs: &Inputs,
    ) -> Result<(), Abort> {
        let apart = first.abs_diff(second);
        if apart > stop.repeat_counts {
            // The motor pushes: it backs off before it comes to rest.
            let abort = Abort::NotRepeated {
                limit_counts: stop.repeat_counts,
                actual_counts: Some(apart),
            };
            self.relieve(abort, self.behind(second, self.config.back_off_counts));
            return Ok(());
        }
        let push = self.witness.push(self.sign(), inputs);
        self.part(Found {
            counts: second,
            uncertainty_counts: apart,
            permille: Some(push as i16),
        })
    }

    /// Whether the axis has backed off a stop, stands where it should and does not push any more.
    fn is_free(
        &mut self,
        stop: &HardStop,
        settling: &mut Settling,
        now_us: u64,
        inputs: &Inputs,
    ) -> Result<bool, Abort> {
        // On the way back the error is that of the contact first.
        if super::Witness::error(self.sign(), inputs) < 0 {
            self.witness.check_way(stop.most_counts, inputs)?;
        }
        if !self.has_arrived(settling, now_us, inputs)? {
            return Ok(false);
        }
        let push = self.witness.push(self.sign(), inputs);
        if push < i32::from(stop.contact_permille) {
            return Ok(true);
        }
        if self.had_its_time(settling, now_us) {
            return Err(Abort::StillPressed {
                limit_permille: stop.contact_permille,
                actual_permille: push as i16,
            });
        }
        Ok(false)
    }

    pub(super) fn seek_switch(
        &mut self,
        switch: &Switch,
        now_us: u64,
        inputs: &Inputs,
    ) -> Result<(), Abort> {
        self.witness.check_way(switch.most_counts, inputs)?;
        if let Some(most_permille) = switch.most_permille {
            self.witness.check_load(most_permille, inputs)?;
        }
        let is_operated = self.witness.is_operated(switch, inputs);
        if !is_operated {
            self.witness.released_us = inputs.switch.map(|level| level.at_us);
        }
        let position = inputs
            .position
            .map_or(self.start_counts, |position| position.value);
        let back = self.config.back_off_counts;
        let phase = self.phase;
        match phase {
            Phase::Leave(_) if !is_operated => {
                let target = self.behind(position, back);
                self.mover.go_to(target, &self.config.search)?;
                self.phase = Phase::Clear(Settling::default());
            }
            Phase::Leave(settling) => return self.leave_on(settling, now_us),
            Phase::Clear(mut settling) => {
                if self.is_off(is_operated, &mut settling, now_us, inputs)? {
                    return self.search();
                }
                self.phase = Phase::Clear(settling);
            }
            Phase::Search(_) if is_operated => return self.retreat(position),
            Phase::Search(settling) => return self.search_on(settling, now_us),
            Phase::Retreat(from, mut settling) => {
                if self.is_off(is_operated, &mut settling, now_us, inputs)? {
                    return self.again(from, self.ahead(from, back));
                }
                self.phase = Phase::Retreat(from, settling);
            }
            Phase::Again(..) if is_operated => return self.stop_behind_edge(now_us, inputs),
            Phase::Again(from, settling) => return self.again_on(back, from, settling, now_us),
            Phase::BehindEdge(found, mut settling) => {
                if self.has_arrived(&mut settling, now_us, inputs)? {
                    return self.leave_edge(found, is_operated);
                }
                self.phase = Phase::BehindEdge(found, settling);
            }
            Phase::Part(found, mut settling) => {
                if self.is_off(is_operated, &mut settling, now_us, inputs)? {
                    return self.finish(found);
                }
                self.phase = Phase::Part(found, settling);
            }
            _ => {}
        }
        Ok(())
    }

    /// Whether the axis has backed off a switch, and stands where it should.
    fn is_off(
        &self,
        is_operated: bool,
        settling: &mut Settling,
        now_us: u64,
        inputs: &Inputs,
    ) -> Result<bool, Abort> {
        let has_arrived = self.has_arrived(settling, now_us, inputs)?;
        if has_arrived && is_operated && self.had_its_time(settling, now_us) {
            return Err(Abort::SwitchStuck {
                way_counts: self.config.back_off_counts,
            });
        }
        Ok(has_arrived && !is_operated)
    }

    /// The edge, from the position that was read last and what the axis has moved on until the switch was seen.
    fn stop_behind_edge(&mut self, now_us: u64, inputs: &Inputs) -> Result<(), Abort> {
        let per_us = self.mover.velocity() / self.config.cycle_us as f32;
        let seen_us = inputs.switch.map_or(now_us, |level| level.at_us);
        let (position, at_us) = inputs
            .position
            .map_or((self.start_counts, seen_us), |position| {
                (position.value, position.at_us)
            });
        let moved_us = seen_us as i64 - at_us as i64;
        let released_us = self.witness.released_us.unwrap_or(seen_us);
        let unseen_us = seen_us.saturating_sub(released_us) + moved_us.unsigned_abs();
        let found = Found {
            counts: position.saturating_add(nearest(per_us * moved_us as f32)),
            uncertainty_counts: ((per_us * unseen_us as f32).abs() as u32).saturating_add(1),
            permille: None,
        };
        self.mover.stop(&self.config.slow)?;
        self.phase = Phase::BehindEdge(found, Settling::default());
        Ok(())
    }

    fn leave_edge(&mut self, found: Found, is_operated: bool) -> Result<(), Abort> {
        if !is_operated {
            return Err(Abort::SwitchUnsteady {
                edge_counts: found.counts,
            });
        }
        self.part(found)
    }

    /// The switch may be read for the last time after the set-points rest.
    fn leave_on(&mut self, mut settling: Settling, now_us: u64) -> Result<(), Abort> {
        if self.is_unanswered(&mut settling, now_us) {
            return Err(Abort::SwitchStuck {
                way_counts: self.config.way_counts,
            });
        }
        self.phase = Phase::Leave(settling);
        Ok(())
    }

    fn search_on(&mut self, mut settling: Settling, now_us: u64) -> Result<(), Abort> {
        if self.is_unanswered(&mut settling, now_us) {
            return Err(Abort::NotFound {
                way_counts: self.config.way_counts,
            });
        }
        self.phase = Phase::Search(settling);
        Ok(())
    }

    fn again_on(
        &mut self,
        limit_counts: u32,
        from: i32,
        mut settling: Settling,
        now_us: u64,
    ) -> Result<(), Abort> {
        if self.is_unanswered(&mut settling, now_us) {
            return Err(Abort::NotRepeated {
                limit_counts,
                actual_counts: None,
            });
        }
        self.phase = Phase::Again(from, settling);
        Ok(())
    }

    /// Whether the set-points rest for so long that two more readings would have shown something.
    pub(super) fn is_unanswered(&self, settling: &mut Settling, now_us: u64) -> bool {
        let limit_us = 2 * u64::from(self.config.watch.max_age_us);
        settling
            .rests_us(self.mover.is_at_rest(), now_us)
            .is_some_and(|rests_us| rests_us > limit_us)
    }

    /// Whether an axis should have arrived, and what is read of it would show it.
    fn had_its_time(&self, settling: &mut Settling, now_us: u64) -> bool {
        self.is_late(settling, now_us) && self.is_unanswered(settling, now_us)
    }

    /// Off the place where something was found.
    fn retreat(&mut self, found: i32) -> Result<(), Abort> {
        let target = self.behind(found, self.config.back_off_counts);
        self.mover.go_to(target, &self.config.search)?;
        self.witness.forget();
        self.phase = Phase::Retreat(found, Settling::default());
        Ok(())
    }

    /// Slowly there again.
    fn again(&mut self, from: i32, target: i32) -> Result<(), Abort> {
        self.mover.go_to(target, &self.config.slow)?;
        self.witness.forget();
        self.phase = Phase::Again(from, Settling::default());
        Ok(())
    }

    /// Off it for good.
    fn part(&mut self, found: Found) -> Result<(), Abort> {
        let target = self.behind(found.counts, self.config.back_off_counts);
        self.mover.go_to(target, &self.config.search)?;
        self.witness.forget();
        self.phase = Phase::Part(found, Settling::default());
        Ok(())
    }
}

/// The nearest integer of a number that is far below 2^31, halves away from 0.
fn nearest(value: f32) -> i32 {
    let half = if value < 0.0 { -0.5 } else { 0.5 };
    (value + half) as i32
}
