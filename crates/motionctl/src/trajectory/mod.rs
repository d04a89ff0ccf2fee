//! A motion from a file: read, check, choose columns, resample to the cycle.
//!
//! Data flows one way: [`lines`] and [`cells`] cut the text, [`name`] and [`header`] read the header, [`columns`] picks
//! time and axes, [`resolve`] their units, [`reader`] and [`table`] keep the points, [`plan`] turns them into command counts at every cycle and refuses what
//! an axis cannot follow, [`motion_report`] says what it found. Nothing runs before all of it has passed. [`options`] is all of
//! it as options of a command line.

mod axes_about;
mod cells;
mod columns;
mod curve;
mod error;
mod exact;
#[cfg(test)]
mod fuzz;
mod header;
mod layout;
mod lines;
mod motion_error;
mod motion_report;
mod name;
mod options;
mod plan;
mod reader;
mod resolve;
mod table;
mod unit;
#[cfg(test)]
mod variants;

use columns::ColumnChoice;
use curve::Interpolation;
use error::TrajectoryError;
pub(crate) use layout::{FieldError, Layout, TimedCounts};
pub(crate) use motion_error::MotionError;
use motion_report::FileReport;
pub(crate) use motion_report::{MotionReport, WithMotion};
pub(crate) use options::{MotionFile, MotionOptions};
pub(crate) use plan::Plan;
use table::Table;
