//! The checks of a board without a board, for a host that wants to know before it sends.

use trajectory::Position;

use super::Segment;
use super::border::Edge;
use super::checks::check_axis;
use crate::config::AxisLimits;
use crate::reason::Reason;
use crate::refused::Refused;

/// Checks the ways of segments, one after the other, as the [`Admission`](super::Admission) of a board does. Times and credit it does not
/// check.
#[derive(Debug, Clone, Copy)]
pub struct SegmentPreview<const AXES: usize> {
    axes: usize,
    limits: [AxisLimits; AXES],
    edges: [Edge; AXES],
}

impl<const AXES: usize> SegmentPreview<AXES> {
    /// For axes with these limits that stand at these positions; `None` for no axis, for more than `AXES`, and for another number of
    /// positions than of limits.
    #[must_use]
    pub fn new(limits: &[AxisLimits], stand: &[Position]) -> Option<Self> {
        let axes = limits.len();
        let mut all = [*limits.first()?; AXES];
        let mut edges = [Edge::default(); AXES];
        if axes > AXES || stand.len() != axes {
            return None;
        }
        for (((all, edge), one), &position) in all.iter_mut().zip(&mut edges).zip(limits).zip(stand)
        {
            (*all, edge.position) = (*one, position);
        }
        Some(Self {
            axes,
            limits: all,
            edges,
        })
    }

    /// Number of axes.
    #[must_use]
    pub const fn axes(&self) -> usize {
        self.axes
    }

    /// The limits of the axes.
    #[must_use]
    pub fn limits(&self) -> &[AxisLimits] {
        self.limits.get(..self.axes).unwrap_or_default()
    }

    /// Goes on where this segment ends.
    ///
    /// # Errors
    /// What a board with these limits would say; the segment is left out.
    pub fn push(&mut self, segment: &Segment) -> Result<(), Refused> {
        if segment.axes.len() != self.axes {
            return Err(Reason::Axes.because(self.axes as i64, segment.axes.len() as i64));
        }
        let mut edges = self.edges;
        let axes = segment.axes.iter().zip(&self.limits).zip(&mut edges);
        for (axis, ((part, limits), edge)) in axes.enumerate() {
            check_axis(axis, part, segment, limits, edge)?;
            edge.position = Position::from_units(part.end);
        }
        self.edges = edges;
        Ok(())
    }
}
