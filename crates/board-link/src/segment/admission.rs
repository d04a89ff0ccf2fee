//! The half of the thread: what a segment must keep before it counts, and orders for the cycle.

use core::sync::atomic::Ordering;

use heapless::spsc::Producer;
use serde::{Deserialize, Serialize};
use trajectory::curve::{Piece, Share};
use trajectory::{Position, Time, TimeScale};

use super::border::{Edge, check_needs, pass, rests, slopes, units};
use super::player::{PlayerState, StreamPhase};
use super::queue::{Admitted, Order, Shared, Start, Tail};
use super::quick::Scale;
use super::{AxisSegment, OfAxes, Segment};
use crate::config::{AxisLimits, WhenDry};
use crate::polynomial::{Needs, Polynomial};
use crate::rate::ONE;
use crate::refused::{Reason, Refused};

/// Segments are at least half a cycle long.
const SHORTEST: Time = Time::from_ticks(1 << 31);
/// A stream is at most so long: 24 days at 1 kHz.
const LONGEST_STREAM: Time = Time::from_cycles(u32::MAX >> 1);
/// Steps of a duration, for the places where an axis turns.
const STEPS: u64 = 1 << 31;

/// How a queue of segments works.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct SegmentConfig {
    /// A stream moves, and moves again after it has run dry, when so much time is buffered, when the queue is full, or the end is there.
    pub lead: Time,
    /// Longest segment.
    pub longest: Time,
    /// A start may be so many cycles ahead.
    pub farthest_start: u32,
}

impl SegmentConfig {
    /// 0.3 s before it moves, segments up to 10 s, starts up to a minute ahead, with this many cycles in a second.
    #[must_use]
    pub const fn with_cycles_per_second(cycles: u32) -> Self {
        Self {
            lead: Time::from_units(3 * cycles as u64, 10),
            longest: Time::from_units(10 * cycles as u64, 1),
            farthest_start: cycles.saturating_mul(60),
        }
    }
}

/// The begin of a stream.
#[derive(Debug, Clone, PartialEq, Eq, Serialize, Deserialize)]
pub struct Begin {
    /// The sender's number of the stream.
    pub stream: u32,
    /// The cycle of the board at which it is at its start; `None` for as soon as [`SegmentConfig::lead`] is buffered.
    pub start: Option<u64>,
    /// What happens when the segments run out.
    pub when_dry: WhenDry,
    /// Override in percent, 0 to 200.
    pub percent: u16,
    /// Where the axes stand, in units of 2^-24 counts: the board must agree.
    pub from: OfAxes<i64>,
}

/// The stream that was begun last.
#[derive(Debug, Clone, Copy)]
struct Stream {
    number: u32,
    generation: u16,
    next_index: u32,
    end: Time,
    rests: bool,
    is_ended: bool,
    is_stopping: bool,
    highest_rate: i64,
}

/// Checks segments and hands them to the [`Player`](super::Player).
pub struct Admission<'q, const AXES: usize> {
    segments: Producer<'q, Admitted<AXES>>,
    orders: Producer<'q, Order<AXES>>,
    shared: &'q Shared,
    axes: usize,
    limits: [AxisLimits; AXES],
    config: SegmentConfig,
    edges: [Edge; AXES],
    stream: Stream,
}

impl<'q, const AXES: usize> Admission<'q, AXES> {
    pub(super) fn new(
        segments: Producer<'q, Admitted<AXES>>,
        orders: Producer<'q, Order<AXES>>,
        shared: &'q Shared,
        (axes, limits): (usize, [AxisLimits; AXES]),
        config: SegmentConfig,
    ) -> Self {
        let generation = shared.status().generation;
        Self {
            segments,
            orders,
            shared,
            axes,
            limits,
            config,
            edges: [Edge::default(); AXES],
            stream: Stream {
                number: 0,
                generation,
                next_index: 0,
                end: Time::ZERO,
                rests: true,
                is_ended: true,
                is_stopping: false,
                highest_rate: 2 * ONE,
            },
        }
    }

    /// Number of axes.
    #[must_use]
    pub const fn axes(&self) -> usize {
        self.axes
    }

    /// Segments that fit the queue.
    #[must_use]
    pub fn capacity(&self) -> usize {
        self.segments.capacity()
    }

    /// So many segments more may be sent.
    #[must_use]
    pub fn credit(&self) -> u32 {
        if self.check_open().is_err() {
            return 0;
        }
        let free = self.segments.capacity().saturating_sub(self.segments.len());
        free as u32
    }

    /// The index of the next segment.
    #[must_use]
    pub const fn next_index(&self) -> u32 {
        self.stream.next_index
    }

    /// The number of the stream that was begun last.
    #[must_use]
    pub const fn stream(&self) -> u32 {
        self.stream.number
    }

    /// What the player does, as of its latest cycle.
    #[must_use]
    pub fn player(&self) -> PlayerState {
        let status = self.shared.status();
        let is_present = status.generation == self.stream.generation;
        let rate = self.shared.rate.load(Ordering::Relaxed);
        PlayerState {
            // A stream that the next cycle will begin waits.
            phase: if is_present {
                status.phase
            } else {
                StreamPhase::Waiting
            },
            time_cycles: self.shared.time_cycles.load(Ordering::Relaxed),
            finished: self.shared.finished.load(Ordering::Relaxed),
            percent: ((100 * i64::from(rate) + ONE / 2) / ONE) as u16,
        }
    }

    /// Begins a stream, at `now` in cycles, for axes whose set-points stand at `stand`.
    ///
    /// # Errors
    /// [`Reason::Moving`], [`Reason::Axes`], [`Reason::Start`], [`Reason::Travel`], [`Reason::Override`], [`Reason::Past`],
    /// [`Reason::Ahead`], [`Reason::Busy`].
    pub fn begin(&mut self, begin: &Begin, stand: &[Position], now: u64) -> Result<(), Refused> {
        if self.player().phase.is_active() {
            let played = i64::from(self.stream.number);
            return Err(Reason::Moving.because(played, i64::from(begin.stream)));
        }
        let from = self.check_from(&begin.from, stand)?;
        let override_rate = override_rate(begin.percent)?;
        let at = self.check_start(begin.start, now)?;
        let generation = self.stream.generation.wrapping_add(1);
        self.order(Order::Begin(Start {
            generation,
            at,
            when_dry: begin.when_dry,
            override_rate,
            from,
        }))?;
        self.edges = from.map(|position| Edge {
            position,
            ..Edge::default()
        });
        self.stream = Stream {
            number: begin.stream,
            generation,
            next_index: 0,
            end: Time::ZERO,
            rests: true,
            is_ended: false,
            is_stopping: false,
            highest_rate: 2 * ONE,
        };
        Ok(())
    }

    fn check_from(&self, from: &[i64], stand: &[Position]) -> Result<[Position; AXES], Refused> {
        if from.len() != self.axes || stand.len() != self.axes {
            return Err(Reason::Axes.because(self.axes as i64, from.len() as i64));
        }
        let mut all = [Position::ZERO; AXES];
        let axes = all.iter_mut().zip(from).zip(stand).zip(&self.limits);
        for (axis, (((all, &from), stand), limits)) in axes.enumerate() {
            *all = Position::from_units(from);
            if all.wide_counts() != stand.wide_counts() {
                return Err(Reason::Start.at(axis, stand.units(), from));
            }
            inside(axis, *all, limits)?;
        }
        Ok(all)
    }

    fn check_start(&self, start: Option<u64>, now: u64) -> Result<u64, Refused> {
        let Some(start) = start else { return Ok(now) };
        if start <= now {
            return Err(Reason::Past.because(now as i64, start as i64));
        }
        let farthest = self.config.farthest_start;
        if start - now > u64::from(farthest) {
            let ticks = |cycles: u64| cycles.min(u64::from(u32::MAX >> 1)) << 32;
            let (expected, actual) = (ticks(farthest.into()), ticks(start - now));
            return Err(Reason::Ahead.because(expected as i64, actual as i64));
        }
        Ok(start)
    }

    /// Takes the segment with this index of this stream.
    ///
    /// # Errors
    /// [`Refused`]: nothing of the segment moves anything.
    pub fn push(&mut self, stream: u32, index: u32, segment: &Segment) -> Result<(), Refused> {
        self.check_stream(stream)?;
        self.check_open()?;
        let next = self.stream.next_index;
        if index != next {
            return Err(Reason::Order.because(next.into(), index.into()));
        }
        if !self.segments.ready() {
            let capacity = self.segments.capacity() as i64;
            return Err(Reason::Full.because(capacity, capacity + 1));
        }
        self.check_time(segment)?;
        if segment.axes.len() != self.axes {
            return Err(Reason::Axes.because(self.axes as i64, segment.axes.len() as i64));
        }
        self.add(segment)
    }

    fn check_stream(&self, stream: u32) -> Result<(), Refused> {
        if stream == self.stream.number {
            return Ok(());
        }
        Err(Reason::Stream.because(self.stream.number.into(), stream.into()))
    }

    fn check_open(&self) -> Result<(), Refused> {
        let phase = self.player().phase;
        if self.stream.is_ended || self.stream.is_stopping {
            return Err(Reason::Ended.because(self.stream.next_index.into(), 0));
        }
        if phase == StreamPhase::DriedUp {
            return Err(Reason::Late.because(self.stream.next_index.into(), 0));
        }
        if !phase.is_active() {
            return Err(Reason::Ended.because(self.stream.next_index.into(), 0));
        }
        Ok(())
    }

    fn check_time(&self, segment: &Segment) -> Result<(), Refused> {
        let (time, ticks) = (segment.time(), |time: Time| time.ticks() as i64);
        if time < SHORTEST {
            return Err(Reason::Close.because(ticks(SHORTEST), ticks(time)));
        }
        if time > self.config.longest {
            let actual = i64::try_from(time.ticks()).unwrap_or(i64::MAX);
            return Err(Reason::Ahead.because(ticks(self.config.longest), actual));
        }
        let end = self.stream.end.after(time);
        if end > LONGEST_STREAM {
            return Err(Reason::Ahead.because(ticks(LONGEST_STREAM), ticks(end)));
        }
        Ok(())
    }

    fn add(&mut self, segment: &Segment) -> Result<(), Refused> {
        let mut edges = self.edges;
        let mut pieces = edges.map(|edge| Piece::line(edge.position, edge.position));
        let mut rate = 2.0_f32;
        let mut is_rest = true;
        let axes = segment.axes.iter().zip(&self.limits).zip(&mut edges);
        for (axis, (((part, limits), edge), piece)) in axes.zip(&mut pieces).enumerate() {
            rate = rate.min(check_axis(axis, part, segment, limits, edge)?);
            *piece = part.piece(edge.position);
            edge.position = Position::from_units(part.end);
            is_rest &= rests(edge, limits);
        }
        let (start, end) = (self.stream.end, self.stream.end.after(segment.time()));
        let admitted = Admitted {
            generation: self.stream.generation,
            start,
            end,
            scale: Scale::of(segment.time()),
            pieces,
        };
        if self.segments.enqueue(admitted).is_err() {
            let capacity = self.segments.capacity() as i64;
            return Err(Reason::Full.because(capacity, capacity + 1));
        }
        self.edges = edges;
        let stream = &mut self.stream;
        stream.end = end;
        stream.rests = is_rest;
        stream.next_index = stream.next_index.wrapping_add(1);
        // 1 is allowed, as was checked.
        let rate = ((rate * ONE as f32) as i64).clamp(ONE, 2 * ONE);
        stream.highest_rate = stream.highest_rate.min(rate);
        let tail = Tail {
            cycles: (end.ticks() >> 32) as u32,
            rests: is_rest,
        };
        self.shared.set_tail(tail, stream.highest_rate);
        Ok(())
    }

    /// No segment comes any more: the motion is complete at the end of the last one.
    ///
    /// # Errors
    /// [`Reason::Stream`], [`Reason::NotAtRest`], [`Reason::Busy`], or what refuses a segment too.
    pub fn end(&mut self, stream: u32) -> Result<(), Refused> {
        self.check_stream(stream)?;
        if self.stream.is_ended && self.player().phase != StreamPhase::Idle {
            return Ok(());
        }
        self.check_open()?;
        if !self.stream.rests {
            let axes = self.edges.iter().zip(&self.limits).take(self.axes);
            let moving = axes
                .enumerate()
                .find(|(_, (edge, limits))| !rests(edge, limits));
            if let Some((axis, (edge, _))) = moving {
                return Err(Reason::NotAtRest.at(axis, 0, units(edge.slope.velocity)));
            }
        }
        self.order(Order::End)?;
        self.stream.is_ended = true;
        Ok(())
    }

    /// Slows down to a standstill on the path, and waits.
    ///
    /// # Errors
    /// [`Reason::NoStream`], [`Reason::Busy`].
    pub fn pause(&mut self) -> Result<(), Refused> {
        self.check_active()?;
        self.order(Order::Pause)
    }

    /// Goes on.
    ///
    /// # Errors
    /// As [`Self::pause`].
    pub fn resume(&mut self) -> Result<(), Refused> {
        self.check_active()?;
        self.order(Order::Resume)
    }

    /// Another speed, 0 to 200 %. Where the limits of an axis allow less, it is held to that.
    ///
    /// # Errors
    /// [`Reason::Override`], or as [`Self::pause`].
    pub fn set_override(&mut self, percent: u16) -> Result<(), Refused> {
        let rate = override_rate(percent)?;
        self.check_active()?;
        self.order(Order::Override(rate))
    }

    /// Slows down to a standstill on the path, and ends; nothing is taken any more.
    ///
    /// # Errors
    /// As [`Self::pause`].
    pub fn stop(&mut self) -> Result<(), Refused> {
        self.check_active()?;
        self.order(Order::Stop)?;
        self.stream.is_stopping = true;
        Ok(())
    }

    fn check_active(&self) -> Result<(), Refused> {
        if self.player().phase.is_active() {
            return Ok(());
        }
        Err(Reason::NoStream.because(0, self.stream.number.into()))
    }

    fn order(&mut self, order: Order<AXES>) -> Result<(), Refused> {
        self.orders.enqueue(order).map_err(|_| {
            let capacity = self.orders.capacity() as i64;
            Reason::Busy.because(capacity, capacity + 1)
        })
    }
}

fn override_rate(percent: u16) -> Result<i64, Refused> {
    let most = TimeScale::MOST_PERCENT;
    if percent > most {
        return Err(Reason::Override.because(most.into(), percent.into()));
    }
    Ok(i64::from(percent) * ONE / 100)
}

fn inside(axis: usize, actual: Position, limits: &AxisLimits) -> Result<(), Refused> {
    let nearest = actual.clamp(limits.lowest, limits.highest.max(limits.lowest));
    if nearest == actual {
        return Ok(());
    }
    Err(Reason::Travel.at(axis, nearest.units(), actual.units()))
}

/// The whole way of one axis. The edge becomes that of the new segment, but for its position; returns the highest rate.
fn check_axis(
    axis: usize,
    part: &AxisSegment,
    segment: &Segment,
    limits: &AxisLimits,
    edge: &mut Edge,
) -> Result<f32, Refused> {
    let from = edge.position;
    inside(axis, Position::from_units(part.end), limits)?;
    if !part.fits(from) {
        let most = units(limits.velocity().into());
        return Err(Reason::Velocity.at(axis, most, i64::MAX));
    }
    let piece = part.piece(from);
    let counts = |units: i64| units as f32 / Position::UNITS as f32;
    let coefficients = piece.coefficients().map(counts);
    let polynomial = Polynomial::new(coefficients, segment.time().cycles());
    let needs = polynomial.needs();
    check_needs(axis, &needs, limits)?;
    for &turn in &polynomial.turns() {
        let share = Share::of((turn * STEPS as f32) as u64, STEPS);
        inside(axis, piece.at(share), limits)?;
    }
    let [leaving, arriving] = slopes(part, from, segment);
    let with_step = pass(axis, edge, leaving, needs, limits)?;
    (edge.slope, edge.needs) = (arriving, needs);
    let most = Needs {
        velocity: limits.velocity(),
        acceleration: limits.acceleration(),
        jerk: limits.jerk(),
    };
    Ok(with_step.highest_rate(&most))
}
