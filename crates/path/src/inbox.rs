//! What has been asked for, in its order.

use trajectory::Position;

use crate::error::PathError;
use crate::request::{Arc, Join, LEAST_FEED, Request};
use crate::shape::Point;

/// Requests in their order.
#[derive(Debug, Clone)]
pub(crate) struct Inbox<const S: usize> {
    requests: [Request<S>; PLACES],
    first: usize,
    count: usize,
    /// Where the path ends.
    pub(crate) end: Point<S>,
}

/// Requests that wait at most.
pub(crate) const PLACES: usize = 4;

impl<const S: usize> Inbox<S> {
    /// Empty; what comes starts at a place.
    pub(crate) const fn at(place: Point<S>) -> Self {
        Self {
            requests: [Request::NONE; PLACES],
            first: 0,
            count: 0,
            end: place,
        }
    }

    pub(crate) const fn is_empty(&self) -> bool {
        self.count == 0
    }

    pub(crate) const fn has_room(&self) -> bool {
        self.count < PLACES
    }

    pub(crate) fn first(&self) -> Option<&Request<S>> {
        if self.count == 0 {
            return None;
        }
        self.requests.get(self.first % PLACES)
    }

    /// Adds a line.
    pub(crate) fn line(
        &mut self,
        end: &[Position; S],
        feed: f32,
        join: Join,
    ) -> Result<bool, PathError> {
        self.add(feed, join, |request, from| request.line(from, end))
    }

    /// Adds an arc.
    pub(crate) fn arc(&mut self, arc: &Arc<S>, feed: f32, join: Join) -> Result<bool, PathError> {
        self.add(feed, join, |request, from| request.arc(from, arc))
    }

    /// Adds what is written into a free place, if that is no error and long enough.
    fn add(
        &mut self,
        feed: f32,
        join: Join,
        write: impl FnOnce(&mut Request<S>, &Point<S>) -> Result<bool, PathError>,
    ) -> Result<bool, PathError> {
        check(feed, join)?;
        let place = (self.first + self.count) % PLACES;
        let has_room = self.has_room();
        let slot = self.requests.get_mut(place).filter(|_| has_room);
        let slot = slot.ok_or(PathError::Full)?;
        let is_piece = write(slot, &self.end)?;
        if is_piece {
            slot.feed = feed;
            slot.join = join;
            self.end = slot.end;
            self.count += 1;
        }
        Ok(is_piece)
    }

    /// Forgets everything; what comes starts at a place.
    pub(crate) const fn restart(&mut self, place: Point<S>) {
        self.count = 0;
        self.end = place;
    }

    /// Forgets the first one.
    pub(crate) const fn pop(&mut self) {
        self.first = (self.first + 1) % PLACES;
        self.count = self.count.saturating_sub(1);
    }
}

fn check(feed: f32, join: Join) -> Result<(), PathError> {
    let tolerance = match join {
        Join::Blend(tolerance) => tolerance,
        Join::Exact | Join::Rest => 1.0,
    };
    if (LEAST_FEED..f32::MAX).contains(&feed) && tolerance > 0.0 && tolerance < f32::MAX {
        return Ok(());
    }
    for actual in [feed, tolerance] {
        if !(actual > 0.0 && actual < f32::MAX) {
            return Err(PathError::NotPositive { actual });
        }
    }
    Err(PathError::Slow { actual: feed })
}
