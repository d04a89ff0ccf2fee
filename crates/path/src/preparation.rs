//! A piece on its way from what was asked for to a piece of the queue: one step a call, so that a cycle takes only what it has time for.

use trajectory::Limits;

use crate::angle::Radius;
use crate::bounds::{self, Slopes};
use crate::corner::{Corner, corner};
use crate::known::Known;
use crate::length;
use crate::machine::Machine;
use crate::measure::Measure;
use crate::order::Order as _;
use crate::queue::Piece;
use crate::request::{Join, Request};
use crate::shape::{Direction, Passage, Shape};
use crate::step::Step;

/// What the axes can do.
#[derive(Debug, Clone)]
pub(crate) struct Axes<M, const A: usize> {
    pub(crate) machine: M,
    pub(crate) limits: [Limits; A],
    /// Cycles of the average.
    pub(crate) cycles: f32,
}

/// What came of a step.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum Progress {
    /// There are more.
    Unfinished,
    /// The piece is in the queue.
    Added {
        /// It is the only one.
        is_alone: bool,
    },
}

#[derive(Debug, Clone)]
pub(crate) struct Preparation<const S: usize, const A: usize> {
    step: Step,
    /// Of an arc, and from its start to its end in its plane.
    radius: Radius,
    turned: [i64; 2],
    length: Measure,
    piece: Piece<S>,
    blend: Piece<S>,
    slopes: [Slopes; A],
    /// How the last piece ends and this one starts; their whole lengths.
    end: Direction<S>,
    start: Direction<S>,
    whole: i64,
    last_is_round: bool,
    /// What the blend replaces of either piece, and where it leaves the one for the other.
    reach: i64,
    from: Passage<S>,
    to: Passage<S>,
}

/// What the velocity of the front can still be changed by.
pub(crate) const LEAST_ACCELERATION: f32 = 1.0 / 262_144.0;

impl<const S: usize, const A: usize> Preparation<S, A> {
    pub(crate) const IDLE: Self = Self {
        step: Step::Turned,
        radius: Radius::NONE,
        turned: [0; 2],
        length: Measure::NONE,
        piece: Piece::EMPTY,
        blend: Piece::EMPTY,
        slopes: [Slopes::NONE; A],
        end: Direction::NONE,
        start: Direction::NONE,
        whole: 0,
        last_is_round: false,
        reach: 0,
        from: Passage::NONE,
        to: Passage::NONE,
    };

    /// Begins anew with the next request.
    pub(crate) const fn restart(&mut self) {
        self.step = Step::Turned;
    }

    /// Instructions of the next step, about.
    pub(crate) const fn cost(&self) -> u32 {
        self.step
            .cost(self.piece.shape.is_round(), self.last_is_round)
    }

    /// The next step with a request, which stays the same until the piece is added.
    #[inline(never)]
    pub(crate) fn advance<M: Machine<S, A>, const Q: usize>(
        &mut self,
        request: &Request<S>,
        most_rate: f32,
        axes: &Axes<M, A>,
        known: &mut Known<S, Q>,
    ) -> Progress {
        self.step = match self.step {
            Step::Turned => {
                self.length = request.measure();
                if request.is_round {
                    self.radius = Radius::of(request.round.radial);
                    self.turned = self.radius.turned(request.round.sweep as u32);
                }
                Step::Shape
            }
            Step::Shape => self.shape(request),
            Step::Start => self.start(),
            Step::Slopes => self.slopes(axes),
            Step::Velocity => {
                let fastest = (self.piece.feed * most_rate).lower(length::FASTEST);
                self.piece.velocity = bounds::velocity(&self.slopes, &axes.limits, fastest);
                Step::Acceleration
            }
            Step::Acceleration => {
                self.piece.acceleration = self.acceleration(axes, self.piece.velocity);
                self.last_is_round = known.last().is_some_and(|(_, last)| last.shape.is_round());
                match request.join {
                    Join::Rest => Step::FromRest,
                    Join::Exact | Join::Blend(_) => Step::LastEnd,
                }
            }
            Step::LastEnd => self.last_end(known),
            Step::Corner => self.corner(request.join),
            Step::BlendFrom => self.blend_from(known),
            Step::BlendDeparts => self.blend_departs(known),
            Step::BlendTo => {
                self.to.point = self.piece.shape.point(self.reach);
                Step::BlendArrives
            }
            Step::BlendArrives => {
                self.to.direction = self.piece.shape.direction(self.reach);
                Step::Blend
            }
            Step::Blend => self.blend(),
            Step::BlendSlopes => {
                bounds::put_slopes_of_blend(&mut self.slopes, &self.blend.shape, &axes.machine);
                Step::BlendBends
            }
            Step::BlendBends => {
                bounds::put_bends_of_blend(&mut self.slopes, &self.blend.shape, &axes.machine);
                Step::BlendVelocity
            }
            Step::BlendVelocity => {
                let fastest = (self.blend.feed * most_rate).lower(length::FASTEST);
                self.blend.velocity = bounds::velocity(&self.slopes, &axes.limits, fastest);
                Step::BlendAcceleration
            }
            Step::BlendAcceleration => self.blend_acceleration(axes),
            Step::BlendFollows => {
                if known.follow_last(&mut self.blend, self.reach) {
                    Step::FollowBlend
                } else {
                    Step::FromRest
                }
            }
            Step::FollowBlend => {
                self.piece.begin = self.reach;
                self.piece.length -= self.reach;
                known.follow(&self.blend, &mut self.piece);
                Step::GuardBlend
            }
            Step::GuardBlend => {
                if known.guard(&self.blend) {
                    Step::AddBlend
                } else {
                    self.piece.begin = 0;
                    self.piece.length += self.reach;
                    Step::FromRest
                }
            }
            Step::AddBlend => {
                known.add(&self.blend, self.reach);
                Step::AddAfterBlend
            }
            Step::AddAfterBlend => {
                known.add_more(&self.piece);
                return self.added(false);
            }
            Step::Follow => {
                if known.follow_last(&mut self.piece, 0) {
                    Step::Guard
                } else {
                    Step::FromRest
                }
            }
            Step::Guard => {
                if known.guard(&self.piece) {
                    Step::Add
                } else {
                    Step::FromRest
                }
            }
            Step::Add => {
                known.add(&self.piece, 0);
                known.plan_anew();
                return self.added(false);
            }
            Step::FromRest => {
                let is_alone = known.start_with(&mut self.piece);
                return self.added(is_alone);
            }
        };
        Progress::Unfinished
    }

    const fn added(&mut self, is_alone: bool) -> Progress {
        self.step = Step::Turned;
        Progress::Added { is_alone }
    }

    fn shape(&mut self, request: &Request<S>) -> Step {
        let ends = (request.from, request.end);
        self.piece.shape = if request.is_round {
            Shape::arc(
                ends,
                &request.round,
                (self.radius, self.turned),
                &self.length,
            )
        } else {
            Shape::line(ends.0, ends.1, &self.length)
        };
        self.piece.begin = 0;
        self.piece.length = self.length.length;
        self.piece.feed = request.feed;
        Step::Start
    }

    fn start(&mut self) -> Step {
        self.start = self.piece.shape.direction(0);
        Step::Slopes
    }

    fn slopes<M: Machine<S, A>>(&mut self, axes: &Axes<M, A>) -> Step {
        self.slopes = bounds::slopes(&self.piece.shape, &self.start, &axes.machine);
        Step::Velocity
    }

    fn acceleration<M>(&self, axes: &Axes<M, A>, velocity: f32) -> f32 {
        // In whole steps, by which the front changes its velocity: it must not plan with more.
        let acceleration = bounds::acceleration(&self.slopes, &axes.limits, velocity, axes.cycles);
        length::velocity_units(length::velocity(acceleration.lower(length::FASTEST)))
    }

    fn last_end<const Q: usize>(&mut self, known: &Known<S, Q>) -> Step {
        let Some((_, last)) = known.last() else {
            return Step::FromRest;
        };
        // The whole shape, of which a blend may have taken the first half.
        self.whole = last.begin + last.length;
        self.end = last.shape.direction(self.whole);
        Step::Corner
    }

    fn corner(&mut self, join: Join) -> Step {
        let tolerance = match join {
            Join::Blend(tolerance) => tolerance,
            Join::Exact | Join::Rest => 0.0,
        };
        let (before, after) = ((&self.end, self.whole), (&self.start, self.piece.length));
        match (corner(before, after, tolerance), join) {
            (Corner::Smooth, _) => Step::Follow,
            (Corner::Blend { reach }, Join::Blend(_)) => {
                self.reach = reach;
                Step::BlendFrom
            }
            (Corner::Blend { .. } | Corner::Rest, _) => Step::FromRest,
        }
    }

    fn blend_from<const Q: usize>(&mut self, known: &Known<S, Q>) -> Step {
        let Some((_, last)) = known.last() else {
            return Step::FromRest;
        };
        self.from.point = last.shape.point(self.whole - self.reach);
        self.blend.feed = last.feed.lower(self.piece.feed);
        Step::BlendDeparts
    }

    fn blend_departs<const Q: usize>(&mut self, known: &Known<S, Q>) -> Step {
        let Some((_, last)) = known.last() else {
            return Step::FromRest;
        };
        self.from.direction = last.shape.direction(self.whole - self.reach);
        Step::BlendTo
    }

    fn blend(&mut self) -> Step {
        self.blend.length = 2 * self.reach;
        self.blend.shape = Shape::blend(&self.from, &self.to, self.blend.length);
        Step::BlendSlopes
    }

    fn blend_acceleration<M>(&mut self, axes: &Axes<M, A>) -> Step {
        let velocity = self.blend.velocity;
        self.blend.acceleration = self.acceleration(axes, velocity);
        if velocity > 0.0 && self.blend.acceleration > LEAST_ACCELERATION {
            Step::BlendFollows
        } else {
            Step::FromRest
        }
    }
}
