//! A random driver of the public API of the master: calls in any order, times with jumps, a controller that is full, displaces, fails
//! and goes bus-off, and drives that reboot, alarm, fall silent or are switched by somebody else.
//!
//! Controller, drives and judge are written from the documents of the protocols and the promises of `docs/master.md`. They share no
//! logic with the master, the simulators or the campaign: frames are taken apart here byte by byte.

mod books;
mod controller;
mod history;
mod judge;
mod judge_commands;
mod judge_moves;
mod run;
mod servo_drive;
mod subject;
mod third_subject;
mod wheel_drive;
mod wheel_subject;

pub use run::{Finding, RUN_CYCLES, Tally, run};
pub use servo_drive::Servos;
pub use third_subject::Thirds;
pub use wheel_subject::Wheels;
