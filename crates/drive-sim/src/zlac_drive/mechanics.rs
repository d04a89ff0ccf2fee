//! What a wheel meets on its way, and how its loops answer.
//!
//! Specification: stops and switch stand still in the room. Their places are turns from where the shaft stood at 0 ns, clockwise up, and no clearing
//! and no power cycle moves them. The shaft never passes a stop; it stops there without bouncing, and the motor pushes as hard as its loops
//! make it, up to its largest current (2015h).

/// The loops between a target and the wheel.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum ZlacLoop {
    /// The wheel does exactly what the profile says.
    #[default]
    Ideal,
    /// A speed loop with 201Dh and 201Eh, below a position loop with 2020h. The guide names the gains and says nothing of the loops: their
    /// structure is the usual one, and their scale is of this project. The feed-forwards 201Fh and 2021h are without effect.
    WithGains,
}

/// What stands beside the shaft.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct ZlacMechanics {
    /// End stops, in turns.
    pub stops_turns: Option<(f64, f64)>,
    /// A switch, in turns; operated from there on, away from 0. It is wired to X1 too, whose level counts where X1 has no function.
    pub switch_turns: Option<f64>,
    /// Current with which a position loop pushes, in mA for each degree between target and shaft. No document has a figure.
    pub push_ma_per_degree: f64,
    /// By how much the current of a speed loop grows while the wheel is held, in mA a second. No document has a figure.
    pub stall_ma_per_s: f64,
    /// The loops.
    pub control: ZlacLoop,
}

impl ZlacMechanics {
    /// A wheel that hangs free.
    pub const FREE: Self = Self {
        stops_turns: None,
        switch_turns: None,
        push_ma_per_degree: 600.0,
        stall_ma_per_s: 30_000.0,
        control: ZlacLoop::Ideal,
    };

    /// Whether the switch is operated where the shaft is.
    pub(super) fn is_operated(&self, shaft_turns: f64) -> bool {
        self.switch_turns
            .is_some_and(|at| shaft_turns * at.signum() >= at.abs())
    }

    /// The place of the stop that a shaft has passed.
    pub(super) fn passed(&self, shaft_turns: f64) -> Option<f64> {
        let (low, high) = self.stops_turns?;
        let place = shaft_turns.clamp(low, high);
        (place != shaft_turns).then_some(place)
    }
}

/// Gains in force, per second.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Gains {
    speed: f64,
    integral: f64,
    position: f64,
}

impl Gains {
    /// From 201Dh, 201Eh and 2020h; the factory's 500, 100 and 50 follow without overshoot.
    pub(super) fn of(speed_kp: u32, speed_ki: u32, position_kp: u32) -> Self {
        Self {
            speed: f64::from(speed_kp) * 0.08,
            integral: f64::from(speed_ki) * 2.0,
            position: f64::from(position_kp) * 0.2,
        }
    }
}

/// Where the profile is, and what the speed loop has gathered.
#[derive(Debug, Clone, Copy, Default, PartialEq)]
pub(super) struct Loops {
    pub(super) position: f64,
    pub(super) speed: f64,
    gathered: f64,
}

impl Loops {
    /// A wheel that nothing holds: the profile begins where it is.
    pub(super) fn at(position: f64, speed: f64) -> Self {
        Self {
            position,
            speed,
            gathered: 0.0,
        }
    }

    /// The acceleration of the wheel, in counts a second squared.
    pub(super) fn acceleration(
        &mut self,
        gains: &Gains,
        wheel: (f64, f64),
        is_position: bool,
        tick_s: f64,
    ) -> f64 {
        let behind = if is_position {
            gains.position * (self.position - wheel.0)
        } else {
            0.0
        };
        let error = self.speed + behind - wheel.1;
        self.gathered += gains.integral * error * tick_s;
        gains.speed * error + self.gathered
    }

    /// Nothing is left to bring the wheel to where the profile rests.
    pub(super) fn is_settled(&self, wheel: (f64, f64), is_position: bool) -> bool {
        const NEAR: f64 = 0.5;
        let is_there = !is_position || (self.position - wheel.0).abs() < NEAR;
        self.speed == 0.0 && wheel.1.abs() < NEAR && is_there && self.gathered.abs() < 100.0
    }
}
