//! What the observer checks of motions that drives make by themselves: only what was asked, nothing behind a fault, no set-point meanwhile,
//! and an end where both sides say that it is.

use can_motion::facts::{Goal, Knowledge};
use can_motion::{AxisState, Instant};
use drive_sim::Frame;
use dyn_can::FunctionCode;
use embedded_can::Frame as _;

use super::moves::Asked;
use super::moving::Moving;
use super::observer::{Observer, Seen, Stopped, broken};
use super::violation::{Promise, Violation};

/// The number in a frame, most significant byte first.
fn number_of(frame: &Frame) -> i64 {
    let first = frame.data().first().copied().unwrap_or(0);
    let sign = if first & 0x80 == 0 { 0_i64 } else { -1 };
    let digits = frame.data().iter();
    digits.fold(sign, |value, byte| value << 8 | i64::from(*byte))
}

impl Observer {
    /// The application told an axis to move, and the master took it.
    pub(super) fn asked_to_move(&mut self, axis: usize, asked: Asked, led_counts: i64) {
        // A word of the application, after which its group may move again.
        self.groups[self.group_of[axis]] = Stopped::default();
        let pending = self.axes[axis].pending.iter().sum::<i64>();
        self.axes[axis].own = Some(Moving {
            asked,
            led_counts: led_counts + pending,
            is_sent: false,
            stops: 0,
            stays_loaded: false,
        });
    }

    /// No set-point may go to a drive that moves by itself.
    pub(super) fn streams_into_a_move(&self, axis: usize) -> bool {
        self.axes[axis].own.is_some_and(|own| own.is_sent)
    }

    pub(super) fn move_frame(
        &mut self,
        index: usize,
        (function, frame): (FunctionCode, &Frame),
        now: Instant,
    ) -> Result<(), Violation> {
        let group = self.groups[self.group_of[index]];
        let Some(own) = &mut self.axes[index].own else {
            let what = format!("axis {index}: nobody asked for {frame}");
            return broken(Promise::Commands, now, what);
        };
        let value = number_of(frame);
        let asked = own.asked;
        if own.is_sent {
            own.stops += 1;
            let way = asked.start.min(asked.end)..=asked.start.max(asked.end);
            if function == FunctionCode::GoAbsolutePosPtp && way.contains(&value) {
                return Ok(());
            }
            let what = format!("axis {index}: {frame} in a move {asked:?}");
            return broken(Promise::Commands, now, what);
        }
        own.is_sent = true;
        let distance = asked.end - asked.start;
        let expected = match (asked.is_relative, asked.by_trigger) {
            (false, false) => (FunctionCode::GoAbsolutePosPtp, asked.end),
            (true, false) => (FunctionCode::GoRelativePosPtp, distance),
            (false, true) => (FunctionCode::GoAbsolutePosSync, asked.end),
            (true, true) => (FunctionCode::GoRelativePosSync, distance),
        };
        if (function, value) != expected {
            let what = format!("axis {index}: {frame} for {asked:?}");
            return broken(Promise::Commands, now, what);
        }
        let promise = if group.by_alarm {
            Promise::AlarmStops
        } else if group.by_fault {
            Promise::FaultStops
        } else {
            return Ok(());
        };
        broken(
            promise,
            now,
            format!("axis {index}: {frame} behind a fault"),
        )
    }

    /// The trigger goes to all drives: something must be loaded, and nobody has a fault.
    pub(super) fn trigger(&self, frame: &Frame, now: Instant) -> Result<(), Violation> {
        let starts = |index: &usize| {
            let own = self.axes[*index].own;
            own.is_some_and(|own| own.asked.by_trigger && own.is_sent)
        };
        let Some(index) = (0..self.axes.len()).find(starts) else {
            return broken(
                Promise::Commands,
                now,
                format!("{frame}: nothing is loaded"),
            );
        };
        if self.groups[self.group_of[index]].by_alarm {
            let what = format!("axis {index}: {frame} behind an alarm");
            return broken(Promise::AlarmStops, now, what);
        }
        Ok(())
    }

    /// The controller gave a frame about a motion back.
    pub(super) fn move_frame_returns(&mut self, index: usize, function: FunctionCode) {
        let Some(own) = &mut self.axes[index].own else {
            return;
        };
        if function == FunctionCode::GoAbsolutePosPtp && own.stops > 0 {
            own.stops -= 1;
        } else if own.stops > 0 {
            // The drive never heard of the motion, only of its stop.
            own.asked.end = own.asked.start;
        } else {
            own.is_sent = false;
        }
    }

    /// A motion that has ended: the axis and its drive must be at one place, and at the end where nobody stopped it.
    pub(super) fn move_goes_on(
        &mut self,
        index: usize,
        seen: &Seen,
        now: Instant,
    ) -> Result<(), Violation> {
        let axis = &mut self.axes[index];
        let Some(own) = axis.own else {
            return Ok(());
        };
        let snapshot = &seen.snapshot;
        let has_own_move = snapshot.facts.has_own_move();
        // No command takes back what was loaded and then stopped: it stays in its drive until that is disabled.
        let stays_loaded =
            snapshot.state == AxisState::Loaded && snapshot.facts.goal != Goal::SyncMove;
        if let Some(own) = &mut axis.own {
            own.stays_loaded = stays_loaded;
        }
        let is_over = snapshot.fault.is_some() || !snapshot.state.is_enabled();
        if is_over && !has_own_move {
            axis.own = None;
            return Ok(());
        }
        let holds = snapshot.state == AxisState::Holding && !has_own_move;
        let is_anchored = snapshot.facts.knowledge == Knowledge::Anchored;
        if !holds || !is_anchored {
            return Ok(());
        }
        axis.own = None;
        if self.axes[index].disturbed {
            return Ok(());
        }
        let sent = i64::from(snapshot.sent_counts);
        let (told, led) = (sent - own.asked.start, seen.led_counts - own.led_counts);
        if told != led {
            let what = format!(
                "axis {index}: after {:?} the master counts {told} on, its drive was led by {led}",
                own.asked
            );
            return broken(Promise::Books, now, what);
        }
        if own.stops == 0 && own.is_sent && sent != own.asked.end {
            let what = format!("axis {index} holds at {sent} after {:?}", own.asked);
            return broken(Promise::Arrives, now, what);
        }
        Ok(())
    }

    /// The run is over: a motion that nothing disturbed has ended.
    pub(super) fn moves_have_ended(
        &self,
        is_disturbed: bool,
        now: Instant,
    ) -> Result<(), Violation> {
        let unended = self
            .axes
            .iter()
            .position(|axis| axis.own.is_some_and(|own| !own.stays_loaded));
        match unended.filter(|_| !is_disturbed) {
            Some(index) => {
                let what = format!("axis {index}: {:?} has not ended", self.axes[index].own);
                broken(Promise::Arrives, now, what)
            }
            None => Ok(()),
        }
    }
}
