//! Before anything moves: fresh readings of an axis that stands still.

use super::ready::Ready;
use super::settle::Settling;
use super::{Found, Homing, Phase};
use crate::abort::Abort;
use crate::config::Method;
use crate::inputs::Inputs;

/// As many positions have to agree.
const POSITIONS: u8 = 3;

impl Homing {
    /// Waits for readings and for standstill, and begins.
    pub(super) fn get_ready(
        &mut self,
        mut ready: Ready,
        now_us: u64,
        inputs: &Inputs,
    ) -> Result<(), Abort> {
        let watch = self.config.watch;
        let began_us = *ready.began_us.get_or_insert(now_us);
        let is_late = now_us.saturating_sub(began_us) >= 2 * u64::from(watch.settle_us);
        if let Err(missing) = self.witness.check_age(&self.config, now_us, inputs) {
            ready.since_us = None;
            ready.range = None;
            ready.positions = 0;
            self.phase = Phase::Ready(ready);
            return if is_late { Err(missing) } else { Ok(()) };
        }
        let since_us = *ready.since_us.get_or_insert(now_us);
        // One that was read before says nothing of now.
        if let Some(position) = inputs
            .position
            .filter(|position| position.at_us >= began_us)
        {
            ready.note(position.value, position.at_us);
        }
        if ready.spread() > watch.still_counts {
            return Err(Abort::NotStill {
                limit_counts: watch.still_counts,
                actual_counts: ready.spread(),
            });
        }
        self.phase = Phase::Ready(ready);
        let stood_us = now_us.saturating_sub(since_us);
        if ready.positions < POSITIONS || stood_us < u64::from(watch.settle_us) / 4 {
            return Ok(());
        }
        self.begin(&ready, inputs)
    }

    fn begin(&mut self, ready: &Ready, inputs: &Inputs) -> Result<(), Abort> {
        let way = self.config.way_counts;
        match self.config.method {
            Method::Here => self.finish(Found {
                counts: ready.range.map_or(0, |(low, high)| {
                    // Between two values of 32 bits.
                    ((i64::from(low) + i64::from(high)) / 2) as i32
                }),
                uncertainty_counts: ready.spread(),
                permille: None,
            }),
            Method::HardStop(stop) => {
                let push = self.witness.push(self.sign(), inputs);
                if push >= i32::from(stop.contact_permille) {
                    return Err(Abort::TorqueAtRest {
                        limit_permille: stop.contact_permille,
                        actual_permille: push as i16,
                    });
                }
                self.search()
            }
            Method::Switch(switch) if self.witness.is_operated(&switch, inputs) => {
                let target = self.behind(self.start_counts, way);
                self.mover.go_to(target, &self.config.search)?;
                self.phase = Phase::Leave(Settling::default());
                Ok(())
            }
            Method::Switch(_) => self.search(),
        }
    }

    /// Fast towards the reference, to the end of the way at most.
    pub(super) fn search(&mut self) -> Result<(), Abort> {
        let target = self.ahead(self.start_counts, self.config.way_counts);
        self.mover.go_to(target, &self.config.search)?;
        self.phase = Phase::Search(Settling::default());
        Ok(())
    }
}
