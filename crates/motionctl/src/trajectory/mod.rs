//! A motion from a file: read, check, choose columns, resample to the cycle.
//!
//! Data flows one way: [`table`] reads numbers and knows their lines, [`columns`] picks time and axes, [`plan`] turns
//! them into command counts at every cycle and refuses what an axis cannot follow. Nothing runs before all of it
//! has passed.

mod columns;
mod curve;
mod error;
mod plan;
mod table;

pub(crate) use columns::{ColumnChoice, Columns};
pub(crate) use curve::Interpolation;
pub(crate) use error::TrajectoryError;
pub(crate) use plan::{AxisScale, Plan, Unit};
pub(crate) use table::Table;
