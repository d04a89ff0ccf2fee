//! In the place of `homing` in an image without it: nothing of it costs anything.

use board_link::{Reason, Refused};
use can_motion::Instant;

use crate::drives::BoardMaster;

/// No origins.
pub(super) struct Homings;

#[allow(
    clippy::unused_self,
    clippy::needless_pass_by_ref_mut,
    reason = "as that with homing"
)]
impl Homings {
    pub(super) const fn new() -> Self {
        Self
    }

    pub(super) fn begin(&mut self, _: u16) -> Result<(), Refused> {
        Err(Reason::Unsupported.plain())
    }

    pub(super) const fn is_awaited(&self) -> bool {
        false
    }

    pub(super) fn cancel(&mut self) {}

    pub(super) fn end(&mut self, _: Refused) -> Option<(u16, Result<(), Refused>)> {
        None
    }

    pub(super) fn forget(&mut self) {}

    pub(super) const fn is_active(&self) -> bool {
        false
    }

    pub(super) fn allows(&self, _: usize, _: i32) -> bool {
        true
    }

    pub(super) fn cycle(
        &mut self,
        _: &mut BoardMaster,
        _: Instant,
    ) -> Option<(u16, Result<(), Refused>)> {
        None
    }
}
