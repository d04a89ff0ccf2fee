//! Profiles of one axis: every way to plan, every way to sample, time scaling, units, curves.

use trajectory::curve::{Chord, Keyframe, KeyframeMotion, Piece, Share};
use trajectory::units::{Ratio, Units};
use trajectory::whole_counts::{Lag, RampDown, StepLimits};
use trajectory::{Limits, Position, Profile, State, Time, TimeScale, Tracker};

use crate::opaque::{bits, consume, flag, number, word};

/// Calls everything once.
pub fn exercise() {
    one_axis();
    tracking();
    time_scale();
    whole_counts();
    units();
    curves();
}

/// Calls what plans and samples one axis with a limit of the jerk or without.
pub fn one_axis() {
    let (start, target) = (state(), position());
    let Ok(limits) = limits() else { return };
    if let Ok(profile) = Profile::to_rest(&start, target, &limits) {
        sampled(&profile);
    }
    if let Ok(profile) = Profile::to_velocity(&start, float(), &limits) {
        sampled(&profile);
    }
    consume(Profile::stop(&start, &limits).map(|stop| stop.end_position()));
}

fn sampled(profile: &Profile) {
    let at = Time::from_ticks(bits());
    consume(profile.position(at).counts());
    consume(profile.state(at));
    consume(profile.extent());
    consume((profile.duration(), profile.is_done(at)));
    for stretch in profile.stretches() {
        consume(stretch);
    }
}

fn tracking() {
    let (Ok(first), Ok(second)) = (limits(), limits()) else {
        return;
    };
    let mut tracker = Tracker::at_rest(number(), first);
    consume(tracker.next(position()));
    consume(tracker.follow(position(), float()));
    consume(tracker.set_limits(second));
    consume((tracker.state(), tracker.is_there()));
}

fn time_scale() {
    let (Ok(mut scale), Ok(running)) = (TimeScale::new(word()), TimeScale::running(word())) else {
        return;
    };
    if flag() {
        scale = running;
    }
    consume(scale.set_override(word() as u16));
    scale.pause();
    scale.resume();
    consume(scale.advance());
    consume((scale.rate(), scale.is_standing(), scale.time_if_paused()));
    consume(Time::from_units(bits(), word()).whole_cycles());
}

fn whole_counts() {
    let mut ramp = RampDown::new(number(), number(), word());
    while flag() {
        ramp.advance();
    }
    consume((
        ramp.set_point(),
        ramp.velocity(),
        ramp.end(),
        ramp.is_done(),
    ));
    consume(RampDown::cycles_to_stop(number(), word()));
    let lag = Lag {
        owed_counts: number(),
        left_over_counts: number(),
        velocity_256ths: number(),
    };
    consume(lag.step(&StepLimits {
        most_counts: word() as u16,
        change_256ths: word(),
    }));
}

fn units() {
    let ratio = Ratio::new(number(), word());
    let Ok(ratio) = ratio.and_then(|ratio| Ratio::new(number(), word())?.times(ratio)) else {
        return;
    };
    let units = Units::new(ratio, number());
    consume((units.to_counts(number()), units.to_units(number())));
    consume(units.limits(float(), float(), float(), word()));
}

fn curves() {
    let share = Share::of(bits(), bits());
    let share = if flag() {
        share.with_minimum_jerk()
    } else {
        share
    };
    for piece in [
        Piece::line(position(), position()),
        Piece::cubic(position(), position(), position(), position()),
        Piece::minimum_jerk(position(), position()),
    ] {
        consume(piece.at(share));
    }
    let chord = || Chord {
        duration: float(),
        velocity: float(),
    };
    consume(chord().velocity_before(chord()));
    let keyframes = [(); 3].map(|()| Keyframe {
        at_ms: word(),
        positions_counts: [number(), number()],
    });
    if let Ok(motion) = KeyframeMotion::new(&keyframes) {
        consume(motion.position(bits()));
        consume(motion.peak_step_counts(word()));
    }
    let velocities = [(); 3].map(|()| [number(), number()]);
    if let Ok(motion) = KeyframeMotion::passing(&keyframes, &velocities) {
        consume(motion.position(bits()));
        consume(motion.peak_step_counts(word()));
    }
}

fn limits() -> Result<Limits, trajectory::RangeError> {
    if flag() {
        Limits::without_jerk(float(), float())
    } else {
        Limits::new(float(), float(), float())
    }
}

fn state() -> State {
    State {
        position: position(),
        velocity: float(),
        acceleration: float(),
    }
}

fn position() -> Position {
    Position::from_units(bits() as i64)
}

/// Any floating-point number, also none.
fn float() -> f32 {
    f32::from_bits(word())
}
