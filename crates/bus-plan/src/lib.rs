#![doc = include_str!("../README.md")]
//!
//! # What a plan proves
//!
//! Under the assumptions listed below, for every payload, every phase of the drives and every order of their replies:
//!
//! - each set-point is through before the next cycle starts, and requests do not pile up;
//! - each reply comes before the master stops waiting for it.
//!
//! The set-points and requests are judged by what the master is known to do (see `cycle.rs`): this admits buses that the general
//! analysis must refuse. The frames of the drives are judged by the general analysis.
//!
//! # What it takes for granted
//!
//! - The master offers its frames at the start of the cycle (within [`BusSetup::release_jitter_us`]) and refills the controller
//!   before it runs empty.
//! - Its frames leave in the configured [`TxOrder`]. A mailbox controller that sends by identifier while the plan says
//!   first-in-first-out makes the plan void.
//! - Drives answer within [`BusSetup::response`], once. Nothing else sends, apart from the alarms, errors and CANopen devices
//!   that are planned. Traffic of CANopen devices is checked for identifiers, not for its load.
//! - One identifier never has two senders at the same instant; the master sees to that with one request at a time for each drive.
//! - Axes that are parameterised while others stream are asked for more than their polls: say so with [`RequestMix::Any`]. It is taken
//!   for granted where drives have several groups, because one group is brought up and enabled while another streams.
//! - The clock of the master and the bit clock agree: a cycle that is planned to the last bit has no room for their drift.
//!
//! # What it gives away
//!
//! Every request of the budget counts as the longest poll of any drive, every reply as the longest reply, and a cycle may see
//! as many late replies as the response window allows. Polls that are rarer than the budget, and replies that are kept out of
//! the set-points by the place of their request, gain nothing here. Where requests may come before set-points without harm,
//! the bounds are those for the worst place.
//!
//! # Cost
//!
//! In a `const`, compile time. At run time the table of [`wire::worst_bits`] is needed in flash (2.6 KiB).

#![no_std]
#![forbid(unsafe_code)]

#[cfg(test)]
extern crate std;

mod advice;
pub mod analysis;
mod burst;
mod canopen;
mod cycle;
mod cycle_plan;
mod demand;
mod drive;
mod refusal;
mod remedies;
mod setup;
pub mod streams;
mod text;

pub use can_frame::{BitRate, wire};

pub use burst::Burst;
pub use canopen::{Canopen, CanopenService, Clash, Identifier};
pub use cycle_plan::CyclePlan;
pub use drive::{Drive, Requests};
pub use refusal::{Refusal, Warning};
pub use remedies::Remedies;
pub use setup::{BusSetup, CycleSetup, RequestMix, ResponseWindow, TxOrder};
