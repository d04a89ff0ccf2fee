//! Name, unit and scale of each axis, for a recording.

use dyn_can::DriveId;
use zlac8030l::NodeId;

use super::Table;
use super::columns::Column;
use super::unit::AxisScale;
use crate::program::MachineSetup;
use crate::recording::{AxisAbout, AxisNaming};

/// The axes of a motion file: as its columns are named.
pub(super) fn of_columns(
    table: &Table,
    scales: &[AxisScale],
    drives: &[DriveId],
) -> Vec<AxisAbout> {
    let columns = table.columns.positions.iter().zip(scales);
    let axes = columns.zip(drives).zip(table.row(0));
    axes.map(|(((column, scale), drive), &start)| AxisAbout {
        start,
        ..AxisAbout::of_drive(*drive).named(naming(column, scale))
    })
    .collect()
}

/// What a column calls its axis.
pub(super) fn naming(column: &Column, scale: &AxisScale) -> AxisNaming {
    AxisNaming {
        name: name(column),
        unit: scale.unit.to_string(),
        counts_per_unit: scale.counts_per_unit(),
    }
}

/// Wheels, whose columns are speeds.
pub(super) fn of_wheels(table: &Table, nodes: &[NodeId]) -> Vec<AxisAbout> {
    let columns = table.columns.positions.iter().zip(nodes);
    let wheels = columns.map(|(column, &node)| AxisAbout {
        name: name(column),
        ..AxisAbout::of_node(node)
    });
    wheels.collect()
}

fn name(column: &Column) -> String {
    match column.label.name.as_str() {
        "" => format!("column {}", column.label.number),
        name => name.to_owned(),
    }
}

/// The motors of a program: in millimetres from where it starts.
pub(super) fn of_program(machine: &MachineSetup, drives: &[DriveId]) -> Vec<AxisAbout> {
    let motors = machine.motors.iter().zip(drives);
    motors
        .map(|(motor, drive)| AxisAbout {
            name: motor.name.clone(),
            unit: "mm".to_owned(),
            counts_per_unit: motor.counts_per_mm,
            ..AxisAbout::of_drive(*drive)
        })
        .collect()
}
