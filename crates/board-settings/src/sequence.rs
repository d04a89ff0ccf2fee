//! The axes that settings want to be homed, one after the other, and what is known of their origins. It is told what is read, and tells the
//! targets.

use crate::configs_of_homing::AxisHoming;
use crate::refusal_of_abort::refused;
use board_link::message::Origin;
use board_link::{Reason, Refused};
use homing::{Abort, Frame, Home, Homing as Search, Inputs, Progress, Travel};

/// What a cycle of the sequence says.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum HomingStep {
    /// Where the set-point of an axis is.
    Target(usize, i32),
    /// An axis has found its origin; the next one follows in the next cycle.
    Found(usize, Home),
    /// All have, or this one has not: it rests, unless the reason is [`Reason::HomePlan`].
    Ended(Result<(), (Refused, Option<Abort>)>),
}

/// An origin that was found.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
struct Known {
    frame: Frame,
    uncertainty: u32,
}

/// The axes of a board that are to be homed, `N` at most, one after the other, and what is known of their origins.
#[derive(Debug)]
pub struct HomingSequence<const N: usize> {
    search: Option<Search>,
    /// The axis that searches.
    axis: usize,
    /// The axes that have searched, a bit each; all of them when nothing goes on.
    done: u16,
    is_active: bool,
    is_cancelled: bool,
    known: [Option<Known>; N],
}

impl<const N: usize> HomingSequence<N> {
    /// Nothing is known.
    pub const NEW: Self = Self {
        search: None,
        axis: 0,
        done: 0,
        is_active: false,
        is_cancelled: false,
        known: [None; N],
    };

    /// Begins with the first axis; what was known is forgotten.
    ///
    /// # Errors
    /// [`Reason::NoHoming`] where no axis is to be homed, [`Reason::Busy`] while it goes on.
    pub fn begin(&mut self, plans: &[Option<AxisHoming>]) -> Result<(), Refused> {
        if self.is_active {
            return Err(Reason::Busy.because(0, 1));
        }
        *self = Self::NEW;
        self.axis = self
            .next(plans)
            .ok_or(Reason::NoHoming.plain())
            .inspect(|_| self.is_active = true)?;
        Ok(())
    }

    /// Slows down the axis that searches, and ends.
    pub fn cancel(&mut self) {
        self.is_cancelled = true;
        if let Some(search) = &mut self.search {
            search.cancel();
        }
    }

    /// Whether there is nothing to forget.
    pub fn is_blank(&self) -> bool {
        !self.is_active && self.known.iter().all(Option::is_none)
    }

    /// Whether it goes on.
    pub const fn is_active(&self) -> bool {
        self.is_active
    }

    /// The axis that searches.
    pub const fn axis(&self) -> usize {
        self.axis
    }

    /// Whether the axis may be there, in counts of its drive.
    pub fn allows(&self, plans: &[Option<AxisHoming>], axis: usize, counts: i32) -> bool {
        if !matches!(plans.get(axis), Some(Some(_))) {
            return true;
        }
        let known = self.known.get(axis).and_then(Option::as_ref);
        known.is_some_and(|known| known.frame.to_axis_inside(counts).is_ok())
    }

    /// What an axis counts from.
    #[must_use]
    pub fn origin(&self, plans: &[Option<AxisHoming>], axis: usize) -> Origin {
        if !matches!(plans.get(axis), Some(Some(_))) {
            return Origin::OfDrive;
        }
        match self.known.get(axis).and_then(Option::as_ref) {
            Some(known) => Origin::Found {
                counts: known.frame.origin_counts(),
                uncertainty: known.uncertainty,
            },
            None => Origin::Unknown,
        }
    }

    /// One cycle, at `now_us`, while every axis follows its set-points: `read` tells what is known of the axis that searches. `None` when
    /// nothing goes on.
    pub fn cycle(
        &mut self,
        plans: &[Option<AxisHoming>],
        now_us: u64,
        read: impl FnOnce(usize) -> Option<Inputs>,
    ) -> Option<HomingStep> {
        if !self.is_active {
            return None;
        }
        let axis = match &self.search {
            Some(_) => self.axis,
            None if self.is_cancelled => return Some(self.end(Err((self.stopped(), None)))),
            None => match self.next(plans) {
                Some(axis) => axis,
                None => return Some(self.end(Ok(()))),
            },
        };
        self.axis = axis;
        let plan = plans.get(axis).copied().flatten();
        let (Some(plan), Some(inputs)) = (plan, read(axis)) else {
            return Some(self.end(Err((Reason::HomePlan.at(axis, 0, 0), None))));
        };
        let search = match &mut self.search {
            Some(search) => search,
            None => match Search::new(plan.search, inputs.sent_counts) {
                Ok(search) => self.search.insert(search),
                // It was checked, so it is the place: too far out for its way.
                Err(_) => return Some(self.end(Err((out_of_range(axis, &plan, &inputs), None)))),
            },
        };
        Some(match search.cycle(now_us, &inputs) {
            Progress::Target(counts) => HomingStep::Target(axis, counts),
            Progress::Found(home) => self.found(axis, &plan, home),
            Progress::Failed(abort) => self.end(Err((refused(axis, &abort), Some(abort)))),
        })
    }

    /// The next axis.
    fn next(&self, plans: &[Option<AxisHoming>]) -> Option<usize> {
        let axes = plans.iter().enumerate().take(N);
        axes.filter_map(|(axis, plan)| Some((plan.as_ref()?.order, axis)))
            .filter(|(_, axis)| self.done >> axis & 1 == 0)
            .min()
            .map(|(_, axis)| axis)
    }

    fn found(&mut self, axis: usize, plan: &AxisHoming, home: Home) -> HomingStep {
        let travel = home.frame.travel_of_drive();
        if let Some((expected, actual)) = leaves(plan.reach, travel) {
            let refused = Reason::HomeRange.at(axis, expected.into(), actual.into());
            return self.end(Err((refused, None)));
        }
        self.search = None;
        self.done |= 1 << axis;
        if let Some(known) = self.known.get_mut(axis) {
            *known = Some(Known {
                frame: home.frame,
                uncertainty: home.uncertainty_counts,
            });
        }
        HomingStep::Found(axis, home)
    }

    fn stopped(&self) -> Refused {
        Reason::HomeStopped.at(self.axis, 0, 0)
    }

    fn end(&mut self, result: Result<(), (Refused, Option<Abort>)>) -> HomingStep {
        self.search = None;
        self.is_active = false;
        HomingStep::Ended(result)
    }
}

/// The end of a travel that is not within what the drive counts, and the nearest one that is.
fn leaves(reach: Travel, travel: Travel) -> Option<(i32, i32)> {
    let ends = [travel.min_counts, travel.max_counts];
    ends.into_iter().find_map(|end| {
        let nearest = end.clamp(reach.min_counts, reach.max_counts.max(reach.min_counts));
        (nearest != end).then_some((nearest, end))
    })
}

fn out_of_range(axis: usize, plan: &AxisHoming, inputs: &Inputs) -> Refused {
    let end = if inputs.sent_counts < 0 {
        plan.reach.min_counts
    } else {
        plan.reach.max_counts
    };
    Reason::HomeRange.at(axis, end.into(), inputs.sent_counts.into())
}

#[cfg(test)]
mod tests {
    use board_link::message::Origin;
    use std::vec;
    use std::vec::Vec;

    use crate::{
        AxisSettings, Board, BusSettings, HomingDirection, HomingMethod, HomingSearch,
        HomingSettings, MotorLimits, Settings, SwitchLevel,
    };
    use homing::{Awaited, Reading};

    use super::*;

    const AXES: usize = 3;
    /// Where a stop is, in both directions, and the edge of a switch.
    const STOP: i32 = 2_000;
    const SWITCH: i32 = 1_500;
    /// 18 degrees.
    const BACK: i32 = 819;

    /// A shaft between two stops that its motor pushes against, with a switch above.
    #[derive(Clone, Copy)]
    struct Shaft {
        target: i32,
        at_us: u64,
    }

    impl Shaft {
        fn inputs(self) -> Inputs {
            let position = self.target.clamp(-STOP, STOP);
            let behind = self.target - position;
            let reading = |value| Reading {
                value,
                at_us: self.at_us,
            };
            Inputs {
                sent_counts: self.target,
                position: Some(Reading {
                    value: position,
                    at_us: self.at_us,
                }),
                torque_permille: Some(Reading {
                    value: if behind == 0 {
                        0
                    } else {
                        400 * behind.signum() as i16
                    },
                    at_us: self.at_us,
                }),
                switch: Some(Reading {
                    value: position >= SWITCH,
                    ..reading(true)
                }),
            }
        }
    }

    fn plans(homings: [Option<HomingSettings>; AXES]) -> Vec<Option<AxisHoming>> {
        let limits = MotorLimits {
            speed_rpm: 150,
            acceleration_rpm_per_s: 1_000,
        };
        let travel = crate::Travel::Counts {
            min: -50_000,
            max: 50_000,
        };
        let axes = homings.into_iter().zip(1..).map(|(homing, id)| {
            let mut axis = AxisSettings::new(id, 4_096, limits, travel);
            axis.polls.torque_us = 20_000;
            axis.homing = homing;
            axis
        });
        let settings = Settings {
            name: Default::default(),
            bus: BusSettings::new(1_000),
            inputs: Default::default(),
            axes: axes.collect(),
        };
        let configs = settings.configs(&Board::STM32F405).unwrap();
        configs.homings.to_vec()
    }

    fn search(direction: HomingDirection) -> HomingSearch {
        HomingSearch::new(direction, 90_000)
    }

    fn stop(direction: HomingDirection) -> HomingSettings {
        HomingSettings::stop(search(direction))
    }

    fn switch() -> HomingSettings {
        HomingSettings::new(HomingMethod::Switch {
            search: search(HomingDirection::Positive),
            pin: 3,
            active: SwitchLevel::High,
        })
    }

    /// The sequence with its shafts.
    struct Machine {
        sequence: HomingSequence<AXES>,
        plans: Vec<Option<AxisHoming>>,
        shafts: [Shaft; AXES],
        now_us: u64,
        /// The axes in the order in which they have found their origins.
        order: Vec<usize>,
        /// Readings stop to come.
        is_silent: bool,
    }

    impl Machine {
        fn new(homings: [Option<HomingSettings>; AXES]) -> Self {
            Self {
                sequence: HomingSequence::NEW,
                plans: plans(homings),
                shafts: [Shaft {
                    target: 0,
                    at_us: 0,
                }; AXES],
                now_us: 0,
                order: Vec::new(),
                is_silent: false,
            }
        }

        fn origin(&self, axis: usize) -> Origin {
            self.sequence.origin(&self.plans, axis)
        }

        fn step(&mut self) -> Option<HomingStep> {
            self.now_us += 1_000;
            if self.now_us.is_multiple_of(20_000) && !self.is_silent {
                let at_us = self.now_us;
                self.shafts.iter_mut().for_each(|shaft| shaft.at_us = at_us);
            }
            let shafts = self.shafts;
            let step = self
                .sequence
                .cycle(&self.plans, self.now_us, |axis| Some(shafts[axis].inputs()));
            match step {
                Some(HomingStep::Target(axis, counts)) => self.shafts[axis].target = counts,
                Some(HomingStep::Found(axis, _)) => self.order.push(axis),
                _ => {}
            }
            step
        }

        /// Runs to the end; what it answers, after how many cycles.
        fn run(&mut self) -> Result<(), Refused> {
            for _ in 0..200_000 {
                if let Some(HomingStep::Ended(result)) = self.step() {
                    return result.map_err(|(refused, _)| refused);
                }
            }
            panic!("it does not end");
        }
    }

    #[test]
    fn each_axis_finds_its_origin_in_the_order_of_the_settings() {
        let first = HomingSettings {
            order: 2,
            ..stop(HomingDirection::Positive)
        };
        let last = HomingSettings {
            order: 2,
            ..switch()
        };
        let here = HomingSettings {
            order: 1,
            reference_millidegrees: 90_000,
            ..HomingSettings::new(HomingMethod::Here)
        };
        let mut machine = Machine::new([Some(first), Some(last), Some(here)]);
        assert!(machine.sequence.begin(&machine.plans).is_ok());
        assert_eq!(machine.run(), Ok(()));
        assert_eq!(machine.order, [2, 0, 1]);
        let found = |axis| machine.origin(axis).counts().unwrap();
        assert!((found(0) - STOP).abs() <= 2, "{}", found(0));
        assert!((found(1) - SWITCH).abs() <= 2, "{}", found(1));
        // It stands at a quarter of a turn of its axis.
        assert_eq!(found(2), -4_096);
        let rests: Vec<i32> = machine.shafts.iter().map(|shaft| shaft.target).collect();
        assert!((rests[0] - (STOP - BACK)).abs() <= 2, "{rests:?}");
        assert!((rests[1] - (SWITCH - BACK)).abs() <= 2, "{rests:?}");
        assert_eq!(rests[2], 0);
        assert!(!machine.sequence.is_active());
        assert_eq!(machine.step(), None);
    }

    #[test]
    fn an_axis_of_no_homing_is_let_alone_and_may_be_anywhere() {
        let mut machine = Machine::new([None, Some(stop(HomingDirection::Negative)), None]);
        assert!(machine.sequence.begin(&machine.plans).is_ok());
        assert_eq!(machine.run(), Ok(()));
        assert_eq!(machine.order, [1]);
        let (sequence, plans) = (&machine.sequence, &machine.plans);
        assert!(sequence.allows(plans, 0, i32::MAX));
        // From the stop on, at -2000.
        let origin = machine.origin(1).counts().unwrap();
        assert!(sequence.allows(plans, 1, origin + 50_000));
        assert!(!sequence.allows(plans, 1, origin + 50_001));
        assert!(sequence.allows(plans, 1, origin - 50_000));
        assert!(!sequence.allows(plans, 1, origin - 50_001));
    }

    #[test]
    fn what_is_not_known_is_allowed_nowhere_and_no_homing_is_refused() {
        let mut machine = Machine::new([Some(stop(HomingDirection::Positive)), None, None]);
        let (sequence, plans) = (&mut machine.sequence, &machine.plans);
        assert!(!sequence.allows(plans, 0, 0));
        assert!(sequence.is_blank());
        assert_eq!(sequence.begin(&[None]), Err(Reason::NoHoming.plain()));
        assert_eq!(sequence.begin(&[]), Err(Reason::NoHoming.plain()));
        assert!(!sequence.is_active());
        assert!(sequence.begin(plans).is_ok());
        assert!(!sequence.is_blank());
        let busy = sequence.begin(plans).unwrap_err();
        assert!(busy.is(Reason::Busy));
    }

    #[test]
    fn a_new_homing_forgets_what_the_one_before_has_found() {
        let mut machine = Machine::new([
            Some(HomingSettings::new(HomingMethod::Here)),
            Some(stop(HomingDirection::Positive)),
            None,
        ]);
        assert!(machine.sequence.begin(&machine.plans).is_ok());
        assert_eq!(machine.run(), Ok(()));
        assert!(machine.sequence.begin(&machine.plans).is_ok());
        assert_eq!(machine.origin(1), Origin::Unknown);
        // What was found before it was stopped stays.
        while machine.order.len() < 3 {
            machine.step();
        }
        machine.sequence.cancel();
        assert_eq!(machine.run(), Err(Reason::HomeStopped.at(0, 0, 0)));
        assert_ne!(machine.origin(0), Origin::Unknown);
        assert_eq!(machine.origin(1), Origin::Unknown);
    }

    #[test]
    fn an_end_in_the_middle_is_a_ramp() {
        for cycles in [1, 300, 500, 600] {
            let mut machine = Machine::new([Some(stop(HomingDirection::Negative)), None, None]);
            assert!(machine.sequence.begin(&machine.plans).is_ok());
            for _ in 0..cycles {
                machine.step();
            }
            let mut targets = vec![machine.shafts[0].target];
            machine.sequence.cancel();
            let mut result = Ok(());
            for _ in 0..10_000 {
                if let Some(HomingStep::Ended(ended)) = machine.step() {
                    result = ended;
                    break;
                }
                targets.push(machine.shafts[0].target);
            }
            let refused = result.map_err(|(refused, _)| refused).unwrap_err();
            assert_eq!(refused, Reason::HomeStopped.at(0, 0, 0));
            let steps: Vec<i32> = targets.windows(2).map(|pair| pair[1] - pair[0]).collect();
            // Never faster than it was, 4.1 counts, and no step ends it at once: 0.08 counts a cycle.
            assert!(
                steps.iter().all(|step| (-5..=0).contains(step)),
                "{steps:?}"
            );
            if steps.first().is_some_and(|step| *step <= -4) {
                assert!(steps.len() > 50, "{steps:?}");
            }
            assert!(machine.sequence.is_blank());
        }
    }

    #[test]
    fn what_is_not_found_is_said_with_the_way_and_the_others_are_not_searched() {
        let near = HomingSettings::stop(HomingSearch::new(HomingDirection::Negative, 20_000));
        let mut machine = Machine::new([Some(near), Some(stop(HomingDirection::Positive)), None]);
        assert!(machine.sequence.begin(&machine.plans).is_ok());
        // 20 degrees.
        assert_eq!(machine.run(), Err(Reason::HomeNotFound.at(0, 910, 910)));
        assert_eq!(machine.order, [0_usize; 0]);
        assert_eq!(machine.shafts[1].target, 0);
    }

    #[test]
    fn readings_that_stay_away_end_it() {
        let mut machine = Machine::new([Some(stop(HomingDirection::Negative)), None, None]);
        assert!(machine.sequence.begin(&machine.plans).is_ok());
        for _ in 0..1_000 {
            machine.step();
        }
        machine.is_silent = true;
        let refused = machine.run().unwrap_err();
        assert_eq!(refused.reason(), Some(Reason::HomePositionOld));
        assert_eq!((refused.expected, refused.axis), (100_000, Some(0)));
    }

    #[test]
    fn an_origin_from_which_the_travel_leaves_the_drive_is_none() {
        let mut machine = Machine::new([Some(HomingSettings::new(HomingMethod::Here)), None, None]);
        let most = (1 << 27) - 1;
        for (at, is_inside) in [(most - 50_000, true), (most - 49_999, false)] {
            machine.shafts[0].target = at;
            machine.sequence = HomingSequence::NEW;
            assert!(machine.sequence.begin(&machine.plans).is_ok());
            let mut step = None;
            while !matches!(step, Some(HomingStep::Ended(_))) {
                machine.now_us += 1_000;
                let reading = Reading {
                    value: at,
                    at_us: machine.now_us,
                };
                step = machine.sequence.cycle(&machine.plans, machine.now_us, |_| {
                    Some(Inputs {
                        sent_counts: at,
                        position: Some(reading),
                        torque_permille: None,
                        switch: None,
                    })
                });
            }
            let most = i64::from(most);
            let expected = if is_inside {
                Ok(())
            } else {
                Err((Reason::HomeRange.at(0, most, most + 1), None))
            };
            assert_eq!(step, Some(HomingStep::Ended(expected)));
        }
    }

    #[test]
    fn each_reason_of_a_search_has_a_number_of_its_own() {
        let aborts = [
            Abort::TooOld {
                what: Awaited::Position,
                limit_us: 1,
                age_us: None,
            },
            Abort::TooOld {
                what: Awaited::Torque,
                limit_us: 1,
                age_us: Some(2),
            },
            Abort::NotStill {
                limit_counts: 1,
                actual_counts: 2,
            },
            Abort::TorqueAtRest {
                limit_permille: 1,
                actual_permille: 2,
            },
            Abort::NotFound { way_counts: 1 },
            Abort::TorqueWithoutError {
                limit_permille: 1,
                actual_permille: 2,
                contact_counts: 3,
                error_counts: 4,
            },
            Abort::ErrorWithoutTorque {
                limit_counts: 1,
                error_counts: 2,
                contact_permille: 3,
                actual_permille: 4,
            },
            Abort::TorqueAgainst {
                contact_permille: 1,
                actual_permille: 2,
                error_counts: 3,
            },
            Abort::Blocked {
                limit_counts: 1,
                actual_counts: 2,
            },
            Abort::Overload {
                limit_permille: 1,
                actual_permille: 2,
            },
            Abort::NotArrived {
                limit_counts: 1,
                actual_counts: 2,
            },
            Abort::StillPressed {
                limit_permille: 1,
                actual_permille: 2,
            },
            Abort::NotRepeated {
                limit_counts: 1,
                actual_counts: None,
            },
            Abort::SwitchStuck { way_counts: 1 },
            Abort::SwitchUnsteady { edge_counts: 1 },
            Abort::Cancelled,
        ];
        let mut numbers: Vec<u16> = aborts
            .iter()
            .map(|abort| {
                let refused = refused(2, abort);
                assert_eq!(refused.axis, Some(2));
                refused.number
            })
            .collect();
        numbers.sort_unstable();
        numbers.dedup();
        assert_eq!(numbers.len(), aborts.len());
        assert!(!numbers.contains(&Reason::HomePlan.number()));
    }
}
