//! Plans and samples profiles, and keeps the figures of each call.

use core::hint::black_box;
use core::sync::atomic::{AtomicU32, Ordering};

use trajectory::{Limits, Position, Profile, State, Time};

/// Moves that are planned.
const MOVES: u32 = 2_000;
/// Samples of each.
const SAMPLES: u32 = 10;

/// Instructions of the calls so far; the emulator reads them by their names once the image sleeps.
pub struct Figure {
    sum: AtomicU32,
    largest: AtomicU32,
}

impl Figure {
    pub(crate) const fn new() -> Self {
        Self {
            sum: AtomicU32::new(0),
            largest: AtomicU32::new(0),
        }
    }

    pub(crate) fn add(&self, instructions: u32) {
        self.sum.fetch_add(instructions, Ordering::Relaxed);
        self.largest.fetch_max(instructions, Ordering::Relaxed);
    }
}

/// Moves from rest to rest.
pub static FIGURE_PLAN_AT_REST: Figure = Figure::new();
/// Moves from any state.
pub static FIGURE_PLAN_MOVING: Figure = Figure::new();
/// The same without a limit of the jerk.
pub static FIGURE_PLAN_TRAPEZOID: Figure = Figure::new();
/// Stops from any state.
pub static FIGURE_STOP: Figure = Figure::new();
/// Positions of all these moves.
pub static FIGURE_SAMPLE: Figure = Figure::new();

/// A generator of numbers (xorshift), the same in every run.
pub(crate) struct Numbers(u32);

impl Numbers {
    pub(crate) const fn new(seed: u32) -> Self {
        Self(seed)
    }

    pub(crate) fn next(&mut self) -> u32 {
        self.0 ^= self.0 << 13;
        self.0 ^= self.0 >> 17;
        self.0 ^= self.0 << 5;
        self.0
    }

    /// From -1 to 1.
    pub(crate) fn share(&mut self) -> f32 {
        (self.next() as i32) as f32 / 2_147_483_648.0
    }

    /// From 2^-n to 2^n, every power alike.
    fn power(&mut self, n: u32) -> f32 {
        let exponent = 127 - n + self.next() % (2 * n);
        f32::from_bits(exponent << 23 | self.next() >> 9)
    }
}

/// Plans and samples. `counter` is the number of instructions so far.
pub fn exercise(counter: fn() -> u32) {
    let mut numbers = Numbers(0x1234_5678);
    let instructions_of = |call: &mut dyn FnMut()| {
        let before = counter();
        call();
        counter().wrapping_sub(before)
    };
    let nothing = instructions_of(&mut || ());
    let measure = |figure: &Figure, call: &mut dyn FnMut()| {
        figure.add(instructions_of(call) - nothing);
    };
    for _ in 0..MOVES {
        let Some((start, target, limits, trapezoid)) = case(&mut numbers) else {
            continue;
        };
        let standing = State::at_rest(start.position.counts());
        let mut profile = Profile::rest(0);
        for (figure, start, limits) in [
            (&FIGURE_PLAN_TRAPEZOID, &start, &trapezoid),
            (&FIGURE_PLAN_AT_REST, &standing, &limits),
            (&FIGURE_PLAN_MOVING, &start, &limits),
        ] {
            measure(figure, &mut || {
                if let Ok(planned) =
                    Profile::to_rest(black_box(start), black_box(target), black_box(limits))
                {
                    profile = planned;
                }
            });
        }
        for sample in 0..SAMPLES {
            let at = Time::from_ticks(
                profile.duration().ticks() / u64::from(SAMPLES) * u64::from(sample),
            );
            measure(&FIGURE_SAMPLE, &mut || {
                black_box(black_box(&profile).position(black_box(at)).counts());
            });
        }
        measure(&FIGURE_STOP, &mut || {
            let _ = black_box(Profile::stop(black_box(&start), black_box(&limits)));
        });
    }
}

/// One move that needs every part of the solver, from beyond every limit; the profile itself is on the stack too.
pub fn plan_one() {
    let start = State {
        velocity: 300.0,
        acceleration: 3.0,
        ..State::at_rest(0)
    };
    let Ok(limits) = Limits::new(100.0, 1.0, 0.01) else {
        return;
    };
    let target = Position::from_counts(-1_000);
    let planned = Profile::to_rest(black_box(&start), black_box(target), black_box(&limits));
    if let Ok(profile) = black_box(&planned) {
        black_box(profile.position(black_box(Time::from_cycles(50))).counts());
        black_box(profile.extent());
    }
}

/// Limits of machines and starts inside and beyond them.
fn case(numbers: &mut Numbers) -> Option<(State, Position, Limits, Limits)> {
    let velocity = 100.0 * numbers.power(7);
    let acceleration = velocity * 0.01 * numbers.power(6);
    let jerk = acceleration * 0.01 * numbers.power(6);
    let beyond = if numbers.next().is_multiple_of(4) {
        3.0
    } else {
        1.0
    };
    let start = State {
        position: Position::from_counts(numbers.next() as i32 >> 4),
        velocity: beyond * velocity * numbers.share(),
        acceleration: beyond * acceleration * numbers.share(),
    };
    let way = numbers.share() * 1_000.0 * numbers.power(12);
    let target = start.position.moved_by(Position::from_counts(way as i32));
    Some((
        start,
        target,
        Limits::new(velocity, acceleration, jerk).ok()?,
        Limits::without_jerk(velocity, acceleration).ok()?,
    ))
}
