//! A motion from a file: read, check, choose columns, resample to the cycle.
//!
//! Data flows one way: [`table`] reads numbers and knows their lines, [`columns`] picks time and axes, [`plan`] turns
//! them into command counts at every cycle and refuses what an axis cannot follow. Nothing runs before all of it
//! has passed. [`options`] is all of it as options of a command line.

mod columns;
mod curve;
mod error;
mod options;
mod plan;
mod table;

use columns::{ColumnChoice, Columns};
use curve::Interpolation;
use error::TrajectoryError;
pub(crate) use options::{MotionError, MotionFile, MotionOptions};
pub(crate) use plan::Plan;
use plan::{AxisScale, Unit};
use table::Table;
