//! The core: facts, the one step that changes them, the one exit, groups, and the schedule. No protocol, no time of its own.

mod axis;
mod calendar;
pub(crate) mod command;
pub(crate) mod counts;
pub(crate) mod drive_move;
pub(crate) mod event;
pub(crate) mod exit;
pub(crate) mod facts;
pub(crate) mod family;
pub(crate) mod group;
mod late;
pub(crate) mod master;
mod own_moves;
pub(crate) mod placement;
pub(crate) mod procedure;
mod schedule;
pub(crate) mod settings;
pub(crate) mod snapshot;
pub(crate) mod stamp;
pub(crate) mod state;
pub(crate) mod step;
pub(crate) mod targets;
mod traffic;
