//! The half of the thread: what a segment must keep before it counts, and orders for the cycle.

use core::sync::atomic::Ordering;

use trajectory::curve::Piece;
use trajectory::{Position, Time};

use super::Segment;
use super::begin::{Begin, SegmentConfig};
use super::border::{Edge, rests, units};
use super::checks::{check_axis, override_rate, passes_inside};
use super::halves::Sender;
use super::phase::{PlayerState, StreamPhase};
use super::queue::{Admitted, Order, Shared, Start, Tail};
use super::quick::{Places, Scale};
use crate::config::AxisLimits;
use crate::message::Origin;
use crate::rate::ONE;
use crate::reason::Reason;
use crate::refused::Refused;

/// Segments are at least half a cycle long.
const SHORTEST: Time = Time::from_ticks(1 << 31);
/// A stream is at most so long: 24 days at 1 kHz.
const LONGEST_STREAM: Time = Time::from_cycles(u32::MAX >> 1);
/// The stream that was begun last.
#[derive(Debug, Clone, Copy)]
pub(super) struct Stream {
    pub(super) number: u32,
    generation: u16,
    next_index: u32,
    end: Time,
    rests: bool,
    is_ended: bool,
    pub(super) is_stopping: bool,
    highest_rate: i64,
}

/// Checks segments and hands them to the [`Player`](super::Player).
pub struct Admission<'q, const AXES: usize> {
    segments: Sender<'q, Admitted<AXES>>,
    orders: Sender<'q, Order<AXES>>,
    shared: &'q Shared,
    axes: usize,
    limits: [AxisLimits; AXES],
    /// What the travels count from.
    origins: [i32; AXES],
    config: SegmentConfig,
    edges: [Edge; AXES],
    pub(super) stream: Stream,
}

impl<'q, const AXES: usize> Admission<'q, AXES> {
    pub(super) fn new(
        segments: Sender<'q, Admitted<AXES>>,
        orders: Sender<'q, Order<AXES>>,
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
            origins: [0; AXES],
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
        self.segments.free() as u32
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

    /// What an axis counts from, for the next stream: its travel moves with its origin.
    ///
    /// # Errors
    /// [`Reason::NotHomed`] when it is not known.
    pub fn set_origin(&mut self, axis: usize, origin: Origin) -> Result<(), Refused> {
        let counts = origin.counts().ok_or(Reason::NotHomed.at(axis, 0, 0))?;
        if let Some(before) = self.origins.get_mut(axis)
            && let Some(limits) = self.limits.get_mut(axis)
        {
            *limits = limits.moved_by(i64::from(counts) - i64::from(*before));
            *before = counts;
        }
        Ok(())
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
        // No stream is played, so nobody looks at the end of the one before; the next one must not start with it.
        self.shared.set_tail(Tail::default());
        self.shared.set_highest_rate(2 * ONE);
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
            passes_inside(axis, *all, limits)?;
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
        if self.segments.free() == 0 {
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
        // 1 is allowed, as was checked.
        let rate = ((rate * ONE as f32) as i64).clamp(ONE, 2 * ONE);
        let highest_rate = self.stream.highest_rate.min(rate);
        self.shared.set_highest_rate(highest_rate);
        let (start, end) = (self.stream.end, self.stream.end.after(segment.time()));
        let mut places = [Places::NONE; AXES];
        for (places, piece) in places.iter_mut().zip(&pieces) {
            *places = Places::of(piece);
        }
        let admitted = Admitted {
            generation: self.stream.generation,
            start,
            end,
            scale: Scale::of(segment.time()),
            places,
            pieces,
        };
        if !self.segments.send(admitted) {
            let capacity = self.segments.capacity() as i64;
            return Err(Reason::Full.because(capacity, capacity + 1));
        }
        self.edges = edges;
        let stream = &mut self.stream;
        (stream.end, stream.rests, stream.highest_rate) = (end, is_rest, highest_rate);
        stream.next_index = stream.next_index.wrapping_add(1);
        self.shared.set_tail(Tail {
            cycles: (end.ticks() >> 32) as u32,
            rests: is_rest,
        });
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

    pub(super) fn order(&mut self, order: Order<AXES>) -> Result<(), Refused> {
        if self.orders.send(order) {
            self.shared.note_change();
            return Ok(());
        }
        let capacity = self.orders.capacity() as i64;
        Err(Reason::Busy.because(capacity, capacity + 1))
    }
}

#[cfg(test)]
mod tests {
    use trajectory::Limits;

    use super::*;
    use crate::config::WhenDry;
    use crate::segment::{AxisSegment, SegmentQueue, Shape};

    /// The cycle may come between a segment and the end that it brings: the end of the stream before must not be taken for it.
    #[test]
    fn a_stream_does_not_begin_with_the_end_of_the_one_before() {
        let limits = AxisLimits {
            motion: Limits::without_jerk(100.0, 1.0).unwrap(),
            lowest: Position::from_counts(-1_000),
            highest: Position::from_counts(1_000),
        };
        let mut queue = SegmentQueue::<1, 4>::new();
        let config = SegmentConfig::with_cycles_per_second(1_000);
        let (mut admission, mut player) = queue.split(&[limits], config).unwrap();
        let begin = |stream| Begin {
            stream,
            start: None,
            when_dry: WhenDry::End,
            percent: 100,
            from: [0].into_iter().collect(),
        };
        let stand = [Position::ZERO];
        let axis = AxisSegment {
            end: 0,
            shape: Shape::Line,
        };
        let segment = Segment {
            duration: 400 << 32,
            axes: [axis].into_iter().collect(),
        };
        admission.begin(&begin(1), &stand, 0).unwrap();
        admission.push(1, 0, &segment).unwrap();
        assert_eq!(admission.shared.tail().cycles, 400);
        admission.stop().unwrap();
        player.advance(1, &stand, &mut [Position::ZERO]);
        admission.begin(&begin(2), &stand, 1).unwrap();
        assert_eq!(admission.shared.tail(), Tail::default());
        assert_eq!(admission.shared.highest_rate(), 2 * ONE);
    }
}
