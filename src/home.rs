//! Homing before the motion, where the configuration asks for it: `config::Homing` is [`Nothing`], of which nothing is in the image, or a
//! [`Sequence`] of the axes, one after the other. The run input begins it, once for each time that the drives are enabled; the motion
//! starts where the axes rest then, and stays within their travel.
#![allow(dead_code, reason = "a configuration uses one of the two")]

use core::marker::PhantomData;

use can_motion::Instant;
use embassy_stm32::pac::GPIOC;
use embassy_stm32::pac::gpio::vals::{Idr, Moder, Pupdr};
use homing::{Abort, Frame, Home, Homing as Search, Progress, Reading};

use crate::board::LAST_SWITCH_PIN;
use crate::config::{AXES, Drives};
use crate::drives::{Board as _, BoardMaster};
use crate::machine;
use crate::words;

/// How far the homing is.
#[derive(Clone, Copy, PartialEq, Eq)]
pub(crate) enum Step {
    /// There is none, or it goes on.
    Wait,
    /// Every axis knows where it is: the motion may start.
    Found,
    /// An axis does not: nothing moves until enable was released.
    Failed,
}

/// What happens between the run input and the motion.
pub(crate) trait Homing {
    /// Nothing is known.
    const NEW: Self;

    /// The motion is asked for; true when it may start at once.
    fn begin(&mut self) -> bool;

    /// One cycle, before that of the master.
    fn cycle(&mut self, master: &mut BoardMaster, is_streaming: bool, now: Instant) -> Step;

    /// The motion is not asked for any more.
    fn cancel(&mut self);

    /// Whether the axis may be there, in counts of its drive.
    fn allows(&self, axis: usize, counts: i32) -> bool;
}

/// No homing: the motion is relative to where the axes stand.
pub(crate) struct Nothing;

impl Homing for Nothing {
    const NEW: Self = Self;

    fn begin(&mut self) -> bool {
        true
    }

    fn cycle(&mut self, _: &mut BoardMaster, _: bool, _: Instant) -> Step {
        Step::Wait
    }

    fn cancel(&mut self) {}

    fn allows(&self, _: usize, _: i32) -> bool {
        true
    }
}

/// The first pin of port C that a switch may hang on: stop, enable and run are below.
const FIRST_SWITCH_PIN: u8 = 3;

/// The homing of one axis.
pub(crate) struct AxisHoming {
    /// Method and limits; its cycle is that of the master.
    pub(crate) search: homing::Config,
    /// The switch, on this pin of port C, 3 to 12: pulled down, not debounced. The first contact counts, and must hold.
    pub(crate) switch_pin: Option<u8>,
}

/// What a configuration says about homing.
pub(crate) trait Plan {
    /// Each axis; `None` for one that is where it is.
    const AXES: [Option<AxisHoming>; AXES];
}

/// The axes one after the other.
pub(crate) struct Sequence<P> {
    search: Option<Search>,
    /// The axis that searches, or the number of axes when it is over.
    axis: usize,
    is_cancelled: bool,
    frames: [Option<Frame>; AXES],
    plan: PhantomData<P>,
}

impl<P: Plan> Sequence<P> {
    /// Each switch hangs on a pin that is free on this board, and is that of one axis.
    const PINS_ARE_FREE: () = {
        let axes = &P::AXES;
        let mut taken = 0_u16;
        let mut axis = 0;
        while axis < AXES {
            if let Some(AxisHoming {
                switch_pin: Some(pin),
                ..
            }) = axes[axis]
            {
                assert!(
                    pin >= FIRST_SWITCH_PIN && pin <= LAST_SWITCH_PIN,
                    "a switch must hang on a pin of port C from 3 on that is free on this board"
                );
                assert!(taken & 1 << pin == 0, "two axes have one switch");
                taken |= 1 << pin;
            }
            axis += 1;
        }
    };
}

impl<P: Plan> Homing for Sequence<P> {
    const NEW: Self = Self {
        search: None,
        axis: AXES,
        is_cancelled: false,
        frames: [None; AXES],
        plan: PhantomData,
    };

    fn begin(&mut self) -> bool {
        if self.frames.iter().any(Option::is_some) {
            return true;
        }
        const { Self::PINS_ARE_FREE };
        for pin in P::AXES.iter().flatten().filter_map(|axis| axis.switch_pin) {
            set_up_switch(pin);
        }
        self.axis = 0;
        self.is_cancelled = false;
        false
    }

    fn cycle(&mut self, master: &mut BoardMaster, is_streaming: bool, now: Instant) -> Step {
        if !is_streaming {
            // The drives are not known to be where they were.
            *self = Self::NEW;
            return Step::Wait;
        }
        if self.is_cancelled && self.search.is_none() && self.axis < AXES {
            // Between two axes.
            *self = Self::NEW;
        }
        while self.axis < AXES {
            match P::AXES.get(self.axis).and_then(Option::as_ref) {
                None => self.axis += 1,
                Some(plan) => match self.search(plan, master, now) {
                    Step::Found => self.axis += 1,
                    step => return self.end_with(step),
                },
            }
            if self.axis == AXES {
                return Step::Found;
            }
        }
        Step::Wait
    }

    fn cancel(&mut self) {
        self.is_cancelled = true;
        if let Some(search) = &mut self.search {
            search.cancel();
        }
    }

    fn allows(&self, axis: usize, counts: i32) -> bool {
        let frame = self.frames.get(axis).and_then(Option::as_ref);
        frame.is_none_or(|frame| frame.to_axis_inside(counts).is_ok())
    }
}

impl<P: Plan> Sequence<P> {
    fn end_with(&mut self, step: Step) -> Step {
        if step != Step::Failed {
            return step;
        }
        let was_cancelled = self.is_cancelled;
        *self = Self::NEW;
        if was_cancelled {
            Step::Wait
        } else {
            Step::Failed
        }
    }

    /// One cycle of the axis that searches.
    fn search(&mut self, plan: &AxisHoming, master: &mut BoardMaster, now: Instant) -> Step {
        let axis = self.axis;
        let (Some(snapshot), Some(config)) = (master.snapshot(axis), machine::axes().get(axis))
        else {
            return Step::Failed;
        };
        let mut inputs = Drives::readings(config, &snapshot);
        inputs.switch = plan.switch_pin.map(|pin| read_switch(pin, now));
        let search = match &mut self.search {
            Some(search) => search,
            None => match Search::new(plan.search, inputs.sent_counts) {
                Ok(search) => {
                    defmt::info!(
                        "axis {=usize}: homing from {=i32} counts",
                        axis,
                        inputs.sent_counts
                    );
                    self.search.insert(search)
                }
                Err(_) => {
                    defmt::error!(
                        "axis {=usize}: the configuration of its homing cannot work",
                        axis
                    );
                    return Step::Failed;
                }
            },
        };
        match search.cycle(now.as_us(), &inputs) {
            Progress::Target(counts) => match master.set_target(axis, counts) {
                Ok(()) => Step::Wait,
                Err(error) => {
                    words::target_refused(axis, &error);
                    Step::Failed
                }
            },
            Progress::Found(home) => {
                self.found(home);
                Step::Found
            }
            Progress::Failed(abort) => {
                write_abort(axis, &abort);
                Step::Failed
            }
        }
    }

    fn found(&mut self, home: Home) {
        defmt::info!(
            "axis {=usize}: its reference is at {=i32} counts, within {=u32}, and its zero at {=i32}",
            self.axis,
            home.found_counts,
            home.uncertainty_counts,
            home.frame.origin_counts()
        );
        if let Some(frame) = self.frames.get_mut(self.axis) {
            *frame = Some(home.frame);
        }
        self.search = None;
    }
}

/// The pin of a switch, pulled down.
pub(crate) fn set_up_switch(pin: u8) {
    let pin = usize::from(pin & 0xF);
    GPIOC.moder().modify(|to| to.set_moder(pin, Moder::INPUT));
    GPIOC
        .pupdr()
        .modify(|to| to.set_pupdr(pin, Pupdr::PULL_DOWN));
}

/// Its level.
pub(crate) fn read_switch(pin: u8, now: Instant) -> Reading<bool> {
    Reading {
        value: GPIOC.idr().read().idr(usize::from(pin & 0xF)) == Idr::HIGH,
        at_us: now.as_us(),
    }
}

/// Tells the log why an axis has found nothing.
pub(crate) fn write_abort(axis: usize, abort: &Abort) {
    match *abort {
        Abort::Cancelled => defmt::warn!("axis {=usize}: its homing was stopped", axis),
        Abort::NotFound { way_counts } => defmt::error!(
            "axis {=usize}: nothing was found within {=u32} counts: no stop, no switch, or the other direction",
            axis,
            way_counts
        ),
        Abort::TooOld { what, limit_us, .. } => defmt::error!(
            "axis {=usize}: its {} is older than {=u32} us: does the configuration poll it?",
            axis,
            what,
            limit_us
        ),
        Abort::TorqueAgainst {
            actual_permille, ..
        } => defmt::error!(
            "axis {=usize}: at the stop its torque has the wrong sign, {=i16} thousandths: is the revision right?",
            axis,
            actual_permille
        ),
        Abort::Blocked { actual_counts, .. } => defmt::error!(
            "axis {=usize}: something is in its way, it is {=i64} counts behind",
            axis,
            actual_counts
        ),
        Abort::SwitchStuck { way_counts } => defmt::error!(
            "axis {=usize}: its switch is still operated after {=u32} counts: stuck, or the other polarity",
            axis,
            way_counts
        ),
        Abort::SwitchUnsteady { edge_counts } => defmt::error!(
            "axis {=usize}: its switch bounces, or is only a short cam, at {=i32} counts",
            axis,
            edge_counts
        ),
        Abort::TorqueAtRest {
            actual_permille, ..
        } => defmt::error!(
            "axis {=usize}: its motor pushes at rest already, {=i16} thousandths: move it off the stop",
            axis,
            actual_permille
        ),
        _ => defmt::error!(
            "axis {=usize}: its homing found no reference: torque, following error or place do not agree",
            axis
        ),
    }
}
