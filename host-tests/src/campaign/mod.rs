//! A campaign that tries to break the master: random motion, random moves of the drives, random faults, and an observer that checks its promises.
//!
//! [`Scenario::from_seed`] draws a run from a seed, [`run`] plays it in virtual time: the unmodified master, the virtual bus and
//! simulated drives. The observer stands between master and controller and at the drives' books; it shares no logic with the
//! master. [`Mutation`] breaks the master on purpose, from outside, to show that the observer sees it.

mod application;
mod draw;
mod generate;
mod injection;
mod moves;
mod moving;
mod mutation;
mod observed_moves;
mod observer;
mod path;
mod run;
mod scenario;
mod tap;
mod violation;
pub mod wheels;

pub use injection::{Injection, Kind};
pub use mutation::Mutation;
pub use path::Path;
pub use run::run;
pub use scenario::{AxisPlan, Command, MoveOrder, Order, Scenario, ServiceTiming};
pub use violation::{Promise, Violation};
