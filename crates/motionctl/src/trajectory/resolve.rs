//! The unit of every column: the one that its name says or the one of the option, never both against each other.

use super::columns::Column;
use super::error::TrajectoryError;
use super::name::NamedUnit;
use super::unit::{AxisScale, TimeUnit, Unit};

const POSITION_UNITS: &str = "a unit of positions (counts, deg, rad, turns, mm)";
const TIME_UNITS: &str = "a unit of time (s, ms, us, ns)";
const SPEED_UNIT: &str = "the speed of a wheel in r/min";

/// The unit of the time column; seconds when nothing says another.
pub(super) fn time_unit(
    option: Option<TimeUnit>,
    column: &Column,
) -> Result<TimeUnit, TrajectoryError> {
    match (&column.unit, option) {
        (NamedUnit::Time(named), Some(option)) if *named != option => {
            Err(TrajectoryError::UnitConflict {
                column: column.label.clone(),
                named: named.to_string(),
                option: format!("--time-unit {option}"),
            })
        }
        (NamedUnit::Time(named), _) => Ok(*named),
        (NamedUnit::Unsaid, option) => Ok(option.unwrap_or_default()),
        (NamedUnit::Position(unit), _) => Err(foreign(column, &unit.to_string(), TIME_UNITS)),
        (NamedUnit::Foreign(unit), _) => Err(foreign(column, unit, TIME_UNITS)),
    }
}

/// The unit of every axis; degrees when neither a name nor the option says another.
pub(super) fn position_units(
    options: &[Unit],
    columns: &[Column],
) -> Result<Vec<Unit>, TrajectoryError> {
    let options = options.iter().copied().map(Some).collect::<Vec<_>>();
    let options = match options[..] {
        [] => vec![None; columns.len()],
        _ => for_each_axis("--unit", &options, columns.len())?,
    };
    let mut units = Vec::with_capacity(columns.len());
    for (column, option) in columns.iter().zip(&options) {
        units.push(match (&column.unit, option) {
            (NamedUnit::Position(Unit::Rpm), _) => {
                return Err(foreign(column, "r/min", POSITION_UNITS));
            }
            (NamedUnit::Position(named), Some(option)) if named != option => {
                return Err(TrajectoryError::UnitConflict {
                    column: column.label.clone(),
                    named: named.to_string(),
                    option: format!("--unit {}", option.option()),
                });
            }
            (NamedUnit::Position(named), _) => Some(*named),
            (NamedUnit::Unsaid, option) => *option,
            (NamedUnit::Time(unit), _) => {
                return Err(foreign(column, &unit.to_string(), POSITION_UNITS));
            }
            (NamedUnit::Foreign(unit), _) => return Err(foreign(column, unit, POSITION_UNITS)),
        });
    }
    if let Some(without) = units.iter().position(Option::is_none)
        && let Some((with, unit)) = columns
            .iter()
            .zip(&units)
            .find_map(|(c, u)| Some((c, (*u)?)))
    {
        return Err(TrajectoryError::MixedUnits {
            with: with.label.clone(),
            unit,
            without: columns[without].label.clone(),
        });
    }
    Ok(units.into_iter().map(Option::unwrap_or_default).collect())
}

/// Speeds of wheels are r/min, and a name may say nothing else.
pub(super) fn check_speeds(columns: &[Column]) -> Result<(), TrajectoryError> {
    for column in columns {
        match &column.unit {
            NamedUnit::Unsaid | NamedUnit::Position(Unit::Rpm) => {}
            NamedUnit::Position(unit) => {
                return Err(foreign(column, &unit.to_string(), SPEED_UNIT));
            }
            NamedUnit::Time(unit) => return Err(foreign(column, &unit.to_string(), SPEED_UNIT)),
            NamedUnit::Foreign(unit) => return Err(foreign(column, unit, SPEED_UNIT)),
        }
    }
    Ok(())
}

/// The scale of every axis, from one value for all or one each.
pub(super) fn scales(
    units: &[Unit],
    columns: &[Column],
    gear_ratio: &[f64],
    counts_per_turn: &[f64],
    mm_per_turn: &[Option<f64>],
) -> Result<Vec<AxisScale>, TrajectoryError> {
    let axes = columns.len();
    let gear_ratios = for_each_axis("--gear-ratio", gear_ratio, axes)?;
    let counts = for_each_axis("--counts-per-turn", counts_per_turn, axes)?;
    let travels = match mm_per_turn {
        [] => vec![None; axes],
        given => for_each_axis("--mm-per-turn", given, axes)?,
    };
    let in_mm = units.contains(&Unit::Mm);
    let mut scales = Vec::with_capacity(axes);
    for (axis, (&unit, column)) in units.iter().zip(columns).enumerate() {
        // One value for all is for those in millimetres, if there are any.
        let is_for_all = mm_per_turn.len() == 1 && in_mm;
        if unit == Unit::Mm && travels[axis].is_none() {
            let column = column.label.clone();
            return Err(TrajectoryError::NoMmPerTurn { column });
        }
        if unit != Unit::Mm && travels[axis].is_some() && !is_for_all {
            let column = column.label.clone();
            return Err(TrajectoryError::MmPerTurnUnused { column, unit });
        }
        scales.push(AxisScale {
            unit,
            gear_ratio: gear_ratios[axis],
            counts_per_turn: counts[axis],
            mm_per_turn: travels[axis].unwrap_or(1.0),
        });
    }
    Ok(scales)
}

/// One value for all axes, or one each.
fn for_each_axis<T: Copy>(
    what: &'static str,
    values: &[T],
    axes: usize,
) -> Result<Vec<T>, TrajectoryError> {
    match values {
        [all] => Ok(vec![*all; axes]),
        each if each.len() == axes => Ok(each.to_vec()),
        _ => Err(TrajectoryError::ListLength {
            what,
            expected: axes,
            actual: values.len(),
        }),
    }
}

fn foreign(column: &Column, unit: &str, expected: &'static str) -> TrajectoryError {
    TrajectoryError::ForeignUnit {
        column: column.label.clone(),
        unit: unit.to_owned(),
        expected,
    }
}

#[cfg(test)]
mod tests {
    use super::super::error::ColumnLabel;
    use super::super::name::Name;
    use super::*;

    fn columns(names: &[&str]) -> Vec<Column> {
        let column = |(index, name): (usize, &&str)| Column {
            index,
            label: ColumnLabel {
                number: index + 1,
                name: (*name).to_owned(),
            },
            unit: Name::parse(name).unit,
        };
        names.iter().enumerate().map(column).collect()
    }

    fn units(options: &[Unit], names: &[&str]) -> Result<Vec<Unit>, String> {
        position_units(options, &columns(names)).map_err(|error| error.to_string())
    }

    #[test]
    fn names_and_options_agree_or_one_of_them_is_silent() {
        use Unit::{Counts, Degrees, Mm, Radians};
        assert_eq!(units(&[], &["a", "b"]), Ok(vec![Degrees, Degrees]));
        assert_eq!(units(&[], &["a_rad", "x_mm"]), Ok(vec![Radians, Mm]));
        assert_eq!(units(&[Counts], &["a", "b"]), Ok(vec![Counts, Counts]));
        assert_eq!(
            units(&[Radians], &["a_rad", "b"]),
            Ok(vec![Radians, Radians])
        );
        assert_eq!(units(&[Radians, Mm], &["a", "b_mm"]), Ok(vec![Radians, Mm]));
        let error = |options: &[Unit], names: &[&str]| units(options, names).unwrap_err();
        assert!(
            error(&[Degrees], &["a_rad"])
                .starts_with("column 1 (a_rad): its name says rad, the option says --unit degrees")
        );
        assert!(error(&[], &["a_rad", "b"]).starts_with(
            "column 1 (a_rad) is in rad by its name, and the name of column 2 (b) has no unit"
        ));
        assert!(error(&[], &["x_m"]).contains("its name says \"m\""));
        assert!(error(&[], &["left_rpm"]).contains("its name says \"r/min\""));
        assert!(error(&[], &["x [kN]"]).contains("its name says \"kN\""));
        assert!(
            error(&[Counts, Counts], &["a"])
                .starts_with("--unit: expected one value for 1 axis, got 2")
        );
    }

    #[test]
    fn time_units() {
        let unit = |option, name| {
            time_unit(option, &columns(&[name])[0]).map_err(|error| error.to_string())
        };
        assert_eq!(unit(None, "time"), Ok(TimeUnit::S));
        assert_eq!(unit(Some(TimeUnit::Us), "time"), Ok(TimeUnit::Us));
        assert_eq!(unit(None, "time_ms"), Ok(TimeUnit::Ms));
        assert_eq!(unit(Some(TimeUnit::Ms), "time_ms"), Ok(TimeUnit::Ms));
        assert!(
            unit(Some(TimeUnit::S), "time_ms")
                .unwrap_err()
                .contains("its name says ms, the option says --time-unit s")
        );
        assert!(
            unit(None, "time_min")
                .unwrap_err()
                .contains("its name says \"min\"")
        );
    }

    #[test]
    fn millimetres_need_the_travel_of_a_turn() {
        let scales = |units: &[Unit], mm: &[Option<f64>]| {
            let names = ["a", "b"];
            scales(
                units,
                &columns(&names[..units.len()]),
                &[1.0],
                &[16_384.0],
                mm,
            )
            .map(|scales| {
                scales
                    .iter()
                    .map(AxisScale::counts_per_unit)
                    .collect::<Vec<_>>()
            })
            .map_err(|error| error.to_string())
        };
        use Unit::{Degrees, Mm};
        assert_eq!(scales(&[Mm, Mm], &[Some(4.0)]), Ok(vec![4_096.0, 4_096.0]));
        assert_eq!(
            scales(&[Mm, Mm], &[Some(4.0), Some(8.0)]),
            Ok(vec![4_096.0, 2_048.0])
        );
        assert_eq!(
            scales(&[Mm, Degrees], &[Some(4.0), None]).map(|s| s[0]),
            Ok(4_096.0)
        );
        assert_eq!(
            scales(&[Mm, Degrees], &[Some(4.0)]).map(|s| s[0]),
            Ok(4_096.0)
        );
        assert!(
            scales(&[Mm], &[])
                .unwrap_err()
                .contains("give --mm-per-turn (or --pitch-mm)")
        );
        assert!(
            scales(&[Degrees], &[Some(4.0)])
                .unwrap_err()
                .contains("--mm-per-turn is for axes in millimetres")
        );
        assert!(
            scales(&[Mm, Degrees], &[Some(4.0), Some(4.0)])
                .unwrap_err()
                .contains("column 2 (b) is in deg")
        );
    }
}
