//! Which column is time and which columns move an axis: as the names say, as the options say, never as the numbers look.

use super::error::{ColumnLabel, TrajectoryError};
use super::header::Header;
use super::name::{Name, NamedUnit};

/// What the user asked for.
#[derive(Debug, Clone, PartialEq, Default)]
pub(crate) struct ColumnChoice {
    /// Column of time; the one that is named so when not given.
    pub(crate) time: Option<String>,
    /// Columns of positions, by name, number or range; those that are named so when not given.
    pub(crate) positions: Vec<String>,
    /// Number of axes, taken from the left.
    pub(crate) axes: Option<usize>,
    /// The columns are the speeds of wheels.
    pub(crate) speeds: bool,
}

/// A column that was chosen.
#[derive(Debug, Clone, PartialEq)]
pub(crate) struct Column {
    /// From 0.
    pub(super) index: usize,
    pub(super) label: ColumnLabel,
    pub(super) unit: NamedUnit,
}

/// The columns of a motion.
#[derive(Debug, Clone, PartialEq)]
pub(crate) struct Columns {
    pub(super) time: Column,
    /// One column an axis.
    pub(super) positions: Vec<Column>,
    pub(super) left_out: Vec<LeftOut>,
}

/// A column that is not read, and why.
pub(super) type LeftOut = (ColumnLabel, &'static str);

/// The columns of a file without names.
pub(super) enum Unnamed {
    Known(Columns),
    /// Two columns: the one that alone increases from line to line is time.
    Two,
}

impl Columns {
    pub(super) fn time(&self) -> &Column {
        &self.time
    }

    /// One an axis.
    pub(super) fn positions(&self) -> &[Column] {
        &self.positions
    }

    /// Chooses by the names of a header line.
    pub(super) fn named(
        choice: &ColumnChoice,
        line: u64,
        names: &[Name],
    ) -> Result<Self, TrajectoryError> {
        let header = Header { line, names };
        let time = match &choice.time {
            Some(wanted) => header.one(wanted)?,
            None => header.time(choice)?,
        };
        let (mut positions, known) = if choice.positions.is_empty() {
            header.positions(choice, time)?
        } else {
            (header.chosen(&choice.positions)?, Vec::new())
        };
        take_axes(choice, line, &mut positions)?;
        if positions.contains(&time) {
            let column = header.label(time);
            return Err(TrajectoryError::TimeIsPosition { column });
        }
        let left_out = header.left_out(time, &positions, &known);
        Ok(Self {
            time: header.column(time),
            positions: positions
                .into_iter()
                .map(|index| header.column(index))
                .collect(),
            left_out,
        })
    }

    /// Chooses by number in a file of `width` columns.
    pub(super) fn unnamed(
        choice: &ColumnChoice,
        line: u64,
        width: usize,
    ) -> Result<Unnamed, TrajectoryError> {
        let header = Header { line, names: &[] };
        let all = || numbered_labels(width);
        if choice.time.is_none()
            && choice.positions.is_empty()
            && choice.axes.is_none_or(|axes| axes == 1)
            && width == 2
        {
            return Ok(Unnamed::Two);
        }
        if width < 2 {
            return Err(TrajectoryError::TooFewColumns {
                line,
                expected: choice.axes.unwrap_or(1),
                actual: 0,
            });
        }
        let no_names = || TrajectoryError::NoNames {
            line,
            width,
            rising: None,
        };
        let mut positions = Vec::new();
        for wanted in &choice.positions {
            positions.extend(header.range(wanted, width)?);
        }
        let time = match &choice.time {
            Some(wanted) => header.numbered(wanted, width)?,
            None => {
                // The only column that is left.
                let mut rest = (0..width).filter(|index| !positions.contains(index));
                match (rest.next(), rest.next()) {
                    (Some(only), None) if !positions.is_empty() => only,
                    _ => return Err(no_names()),
                }
            }
        };
        if choice.positions.is_empty() {
            if choice.axes.is_none() && width > 2 {
                return Err(no_names());
            }
            positions = (0..width).filter(|index| *index != time).collect();
        }
        take_axes(choice, line, &mut positions)?;
        let label = |index: usize| all()[index].clone();
        if positions.contains(&time) {
            return Err(TrajectoryError::TimeIsPosition {
                column: label(time),
            });
        }
        Ok(Unnamed::Known(Self::by_number(time, &positions, width)))
    }

    /// Columns without names.
    pub(super) fn by_number(time: usize, positions: &[usize], width: usize) -> Self {
        let labels = numbered_labels(width);
        let column = |index: usize| Column {
            index,
            label: labels[index].clone(),
            unit: NamedUnit::Unsaid,
        };
        let is_left = |index: &usize| *index != time && !positions.contains(index);
        Self {
            time: column(time),
            positions: positions.iter().map(|index| column(*index)).collect(),
            left_out: (0..width)
                .filter(is_left)
                .map(|index| (labels[index].clone(), "not chosen"))
                .collect(),
        }
    }
}

fn numbered_labels(width: usize) -> Vec<ColumnLabel> {
    let label = |number| ColumnLabel {
        number,
        name: String::new(),
    };
    (1..=width).map(label).collect()
}

/// The leftmost columns, as many as there are axes.
fn take_axes(
    choice: &ColumnChoice,
    line: u64,
    positions: &mut Vec<usize>,
) -> Result<(), TrajectoryError> {
    let expected = choice.axes.unwrap_or(1).max(1);
    if expected > positions.len() {
        return Err(TrajectoryError::TooFewColumns {
            line,
            expected,
            actual: positions.len(),
        });
    }
    positions.truncate(choice.axes.unwrap_or(positions.len()));
    Ok(())
}

#[cfg(test)]
mod tests {
    use super::*;

    fn choose(header: &str, columns: &[&str], axes: Option<usize>) -> Result<Columns, String> {
        let choice = ColumnChoice {
            positions: columns.iter().map(ToString::to_string).collect(),
            axes,
            ..ColumnChoice::default()
        };
        let names: Vec<Name> = header.split(',').map(Name::parse).collect();
        Columns::named(&choice, 1, &names).map_err(|error| error.to_string())
    }

    fn indices(header: &str) -> (usize, Vec<usize>) {
        let columns = choose(header, &[], None).unwrap();
        let positions = columns.positions.iter().map(|column| column.index);
        (columns.time.index, positions.collect())
    }

    #[test]
    fn names_decide_wherever_they_stand() {
        assert_eq!(indices("t,a,b"), (0, vec![1, 2]));
        assert_eq!(indices("q1,q2,time"), (2, vec![0, 1]));
        assert_eq!(indices(",t,a,b"), (1, vec![2, 3]));
        assert_eq!(indices("t,pos,vel,acc"), (0, vec![1]));
        assert_eq!(indices("vel_1,pos_1,vel_2,time_s,pos_2"), (3, vec![1, 4]));
        assert_eq!(indices("t,joint1,joint2"), (0, vec![1, 2]));
        assert_eq!(indices("index,time,q1,qd1,tau1"), (1, vec![2]));
    }

    #[test]
    fn doubt_is_refused_with_the_option_that_ends_it() {
        for (header, expected) in [
            (
                "x,a,b",
                "expected a column named time, got column 1 (x), column 2 (a), column 3 (b)",
            ),
            (
                "time,timestamp,a",
                "expected one column of time, got column 1 (time), column 2 (timestamp)",
            ),
            ("t,x,v", "column 3 (v) may be an axis or another quantity"),
            ("t,x,v,a", "column 3 (v), column 4 (a) may be"),
            ("t,pos,gripper", "column 3 (gripper) may be an axis or not"),
            (
                "t,target_pos,actual_pos",
                "commanded or measured values of one thing",
            ),
            (
                "t,vel,acc",
                "expected at least one column of positions, got column 2 (vel): a speed, column 3 (acc): an acceleration",
            ),
            ("t,a,a", "several columns are called \"a\""),
        ] {
            let error = choose(header, &[], None).unwrap_err();
            assert!(error.contains(expected), "{header}: {error}");
            assert!(
                error.contains("--columns") || error.contains("--time-column"),
                "{error}"
            );
        }
    }

    #[test]
    fn a_word_that_is_not_known_decides_nothing() {
        // Feeds, currents, filters, units, attitudes and prose beside an axis, or several of them alone.
        for header in [
            "t,x,F",
            "t,x,iq",
            "t,x,freq",
            "t,x,confidence",
            "t,x,timestep",
            "t,x,dwell",
            "t,x,x_filtered",
            "t,x,x_max",
            "t,x,x_old",
            "t,x,a_x",
            "t,x_chains",
            "t,encoder",
            "t,x_mDeg_raw",
            "t,mm x",
            "t,deg_x",
            "t,pos_filtered",
            "t,gripper_open",
            "time,lat,lon,alt",
            "t,tx,ty,tz,qx,qy,qz,qw",
            "t,dist,heading",
            "t,ch1,ch2",
            "t,x,\u{fffd}",
        ] {
            let error = choose(header, &[], None).unwrap_err();
            assert!(
                error.contains("may be an axis or another quantity; choose with --columns"),
                "{header}: {error}"
            );
        }
        let error = choose("t,x_sp,x_pv", &[], None).unwrap_err();
        assert!(error.contains("may be commanded or measured"), "{error}");
        // Nothing else can be the axis.
        assert_eq!(indices("t,schlitten"), (0, vec![1]));
        assert_eq!(indices("schlitten,status,time"), (2, vec![0]));
    }

    #[test]
    fn names_of_axes_are_known() {
        for header in [
            "t,X,Y,Z,A,B,C",
            "t,J1,J2",
            "time,shoulder_pan_joint,shoulder_lift_joint,elbow_joint",
            "t,left_hip_yaw,left_knee",
            "t,motor_1,motor_2",
            "t,theta1,theta2",
            "t,robot.joint_1,robot.joint_2",
            "t,position_left,position_right",
        ] {
            let axes = header.split(',').count() - 1;
            assert_eq!(indices(header).1.len(), axes, "{header}");
        }
    }

    #[test]
    fn a_time_that_something_else_was_made_of_is_none() {
        for header in [
            "time_jiffies,x",
            "time_samples,x",
            "time_step,x",
            "time_index,x",
            "time_\u{fffd}s,x",
            "stamp_filtered,x",
        ] {
            let error = choose(header, &[], None).unwrap_err();
            assert!(
                error.starts_with("line 1: expected a column named time"),
                "{error}"
            );
        }
        for header in ["time_since_boot_ms,x", "stamp_of_start,x", "unix_time,x"] {
            assert_eq!(indices(header), (0, vec![1]), "{header}");
        }
    }

    #[test]
    fn columns_by_name_number_and_range() {
        let chosen = |columns: &[&str], axes| {
            let columns = choose("t,a,b,c", columns, axes).unwrap();
            columns
                .positions
                .iter()
                .map(|column| column.index)
                .collect::<Vec<_>>()
        };
        assert_eq!(chosen(&["c", "2"], None), [3, 1]);
        assert_eq!(chosen(&["2-4"], None), [1, 2, 3]);
        assert_eq!(chosen(&[], Some(2)), [1, 2]);
        let error = |columns: &[&str], axes| choose("t,a", columns, axes).unwrap_err();
        assert_eq!(
            error(&["elbow"], None),
            "there is no column \"elbow\"; the file has t, a"
        );
        assert!(error(&["0"], None).contains("there is no column \"0\""));
        assert!(error(&["1-99999999999"], None).contains("there is no column \"99999999999\""));
        assert!(error(&["5-2"], None).contains("\"5-2\" is not a column"));
        assert!(error(&["t"], None).contains("column 1 (t) is the time"));
        assert!(
            error(&[], Some(2))
                .starts_with("line 1: expected time and 2 axes, got 1 column beside time")
        );
    }

    #[test]
    fn without_names_everything_must_be_said() {
        let unnamed = |time: Option<&str>, columns: &[&str], axes, width| {
            let choice = ColumnChoice {
                time: time.map(str::to_owned),
                positions: columns.iter().map(ToString::to_string).collect(),
                axes,
                speeds: false,
            };
            match Columns::unnamed(&choice, 1, width).ok()? {
                Unnamed::Two => Some((9, vec![])),
                Unnamed::Known(columns) => {
                    let positions = columns.positions.iter().map(|column| column.index);
                    Some((columns.time.index, positions.collect()))
                }
            }
        };
        assert_eq!(unnamed(None, &[], None, 2), Some((9, vec![])));
        assert_eq!(unnamed(None, &[], None, 3), None);
        assert_eq!(unnamed(Some("1"), &[], None, 3), None);
        assert_eq!(unnamed(None, &["2"], None, 3), None);
        assert_eq!(unnamed(None, &["2-3"], None, 3), Some((0, vec![1, 2])));
        assert_eq!(unnamed(Some("1"), &["3"], None, 3), Some((0, vec![2])));
        assert_eq!(
            unnamed(Some("1"), &[], Some(6), 13),
            Some((0, vec![1, 2, 3, 4, 5, 6]))
        );
        assert_eq!(unnamed(Some("2"), &[], None, 2), Some((1, vec![0])));
    }
}
