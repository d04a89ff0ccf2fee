//! Times that lie long ago: a master that runs for days, or is left alone for hours, takes nothing old for new.

use can_motion::facts::{Brake, Facts, Power};
use can_motion::family::{CommonFault, Meaning, View};
use can_motion::{AxisState, Instant, Stage};

use crate::drive::Call;
use crate::family::{Axis, axis};
use crate::rig::{FINE, G, Rig};

/// Longer than the lower half of an instant: what is as old as this looks as if it were to come.
const HALF_US: u64 = 1 << 31;
/// The greatest age that is told.
const MOST_US: u64 = 1 << 30;

impl Rig {
    /// So much time passes, with a cycle in every step.
    fn wait(&mut self, us: u64, step_us: u64) {
        let end = self.now.as_us() + us;
        while self.now.as_us() < end {
            self.now = Instant::from_us((self.now.as_us() + step_us).min(end));
            self.master.begin_cycle(self.now);
            self.send();
        }
    }
}

/// With cycles all the while, and without.
const STEPS: [u64; 2] = [100_000_000, u64::MAX / 2];

#[test]
fn the_time_of_an_old_event_is_never_in_the_future() {
    for step_us in STEPS {
        let mut rig = Rig::new(&[axis(1)]);
        let at = rig.now;
        rig.says(1, Meaning::stage(Stage::Locating));
        rig.wait(HALF_US + 5_000, step_us);
        let event = rig.master.next_event().expect("the change of state");
        assert!(event.at > at);
        let age_us = rig.now.us_since(event.at);
        assert!(
            (MOST_US..=MOST_US + (1 << 28)).contains(&age_us),
            "{age_us}"
        );
    }
}

#[test]
fn an_axis_that_has_been_as_it_is_for_long_does_not_look_as_if_it_came_just_now() {
    for step_us in STEPS {
        let mut rig = Rig::ready(&[axis(1)]);
        rig.wait(HALF_US + 5_000, step_us);
        rig.says(1, Meaning::NONE);
        match rig.seen(0).calls.last() {
            Some(Call::Heard(_, since)) => {
                let age_us = rig.now.us_since(*since);
                assert!(age_us >= MOST_US, "{age_us}");
            }
            other => panic!("{other:?}"),
        }
    }
}

#[test]
fn drives_are_told_to_keep_their_times() {
    let mut rig = Rig::ready(&[axis(1)]);
    let kept = |rig: &Rig, before| {
        let mut told = rig.told_since(0, before);
        told.retain(|call| matches!(call, Call::KeepStamps { .. }));
        told
    };
    // The first call of all comes long after nothing.
    let before = rig.times_told(0);
    rig.wait(268_000_000, 1_000_000);
    let few = kept(&rig, before);
    assert!(few.len() <= 1, "{few:?}");
    rig.wait(270_000_000, 1_000_000);
    let recent = Call::KeepStamps { is_long_ago: false };
    let told = kept(&rig, before);
    assert_eq!((told.len() - few.len(), told.last()), (1, Some(&recent)));
    for (pause_us, is_long_ago) in [(MOST_US - 1, false), (MOST_US, true)] {
        // From one call to the next.
        rig.wait(1 << 28, u64::MAX / 2);
        let before = rig.times_told(0);
        rig.wait(pause_us, u64::MAX / 2);
        assert_eq!(kept(&rig, before), [Call::KeepStamps { is_long_ago }]);
    }
}

#[test]
fn a_drive_that_never_confirms_is_told_again_also_after_hours() {
    let mut rig = Rig::holding(&[axis(1)]);
    rig.master.disable(rig.now, G);
    rig.cycle();
    assert_eq!(rig.power_of(0), Power::OffSent);
    rig.wait(HALF_US + 5_000, u64::MAX / 2);
    assert_ne!(rig.master.next_event(), None);
    rig.now = rig.now + 1_000;
    rig.master.begin_cycle(rig.now);
    // It is off that is wanted, and nothing was confirmed meanwhile.
    assert_eq!(rig.state(0), AxisState::Disabling);
}

#[test]
fn an_outage_of_hours_is_an_outage() {
    for is_plain in [false, true] {
        let mut rig = Rig::streaming(&[Axis {
            is_plain,
            ..axis(1)
        }]);
        rig.cycle();
        rig.now = Instant::from_us(rig.now.as_us() + HALF_US + 5_000);
        rig.master.begin_cycle(rig.now);
        assert_eq!(rig.fault(0), Some(CommonFault::Bus.into()));
    }
}

#[test]
fn a_shaft_that_never_stands_is_a_fault_also_when_nobody_looked_for_hours() {
    let mut rig = Rig::ready(&[axis(1)]);
    rig.master.enable(rig.now, G).expect("a ready drive");
    rig.says(
        1,
        Meaning {
            is_checked: true,
            ..Meaning::NONE
        },
    );
    assert_eq!(rig.state(0), AxisState::AwaitingStandstill);
    rig.now = Instant::from_us(rig.now.as_us() + HALF_US + 5_000);
    rig.master.begin_cycle(rig.now);
    assert_eq!(rig.fault(0), Some(CommonFault::NotConfirmed.into()));
    rig.says(1, FINE);
}

#[test]
fn a_drive_sees_how_long_its_axis_has_been_as_it_is() {
    let since = Instant::from_us(5_000);
    let view = View::new(Facts::start(Brake::Absent), Stage::Probing, since);
    assert!(!view.has_lasted(since + 19, 20));
    assert!(view.has_lasted(since + 20, 20));
}
