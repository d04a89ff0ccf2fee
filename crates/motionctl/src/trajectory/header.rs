//! The names of the columns of a file, asked for time, positions, and columns by name and number.

use super::columns::{Column, ColumnChoice, LeftOut};
use super::error::{ColumnLabel, TrajectoryError};
use super::name::{Name, Quantity};

/// The names of a file.
pub(super) struct Header<'a> {
    pub(super) line: u64,
    /// Empty in a file without names.
    pub(super) names: &'a [Name],
}

impl Header<'_> {
    pub(super) fn label(&self, index: usize) -> ColumnLabel {
        ColumnLabel {
            number: index + 1,
            name: self.names[index].text.clone(),
        }
    }

    fn labels(&self, indices: &[usize]) -> Vec<ColumnLabel> {
        indices.iter().map(|&index| self.label(index)).collect()
    }

    pub(super) fn column(&self, index: usize) -> Column {
        Column {
            index,
            label: self.label(index),
            unit: self.names[index].unit.clone(),
        }
    }

    fn with(&self, quantity: Quantity) -> Vec<usize> {
        let is_one = |index: &usize| self.names[*index].quantity == quantity;
        (0..self.names.len()).filter(is_one).collect()
    }

    /// The one column that is named time.
    pub(super) fn time(&self, choice: &ColumnChoice) -> Result<usize, TrajectoryError> {
        let mut times = self.with(Quantity::Time);
        if times.len() > 1 && !choice.positions.is_empty() {
            let chosen = self.chosen(&choice.positions)?;
            times.retain(|index| !chosen.contains(index));
        }
        match times[..] {
            [one] => Ok(one),
            [] => Err(TrajectoryError::NoTime {
                line: self.line,
                names: (0..self.names.len())
                    .map(|index| self.label(index))
                    .collect(),
            }),
            _ => Err(TrajectoryError::SeveralTimes {
                line: self.line,
                columns: self.labels(&times),
            }),
        }
    }

    /// The columns that move an axis, and the others with their reasons.
    pub(super) fn positions(
        &self,
        choice: &ColumnChoice,
        time: usize,
    ) -> Result<(Vec<usize>, Vec<LeftOut>), TrajectoryError> {
        let (mut stated, mut open, mut unknown, mut unclear, mut left_out) =
            (Vec::new(), Vec::new(), Vec::new(), Vec::new(), Vec::new());
        for (index, name) in self.names.iter().enumerate() {
            if index == time {
                continue;
            }
            match (name.quantity, choice.speeds) {
                (Quantity::Position, false) | (Quantity::Speed, true) => stated.push(index),
                (Quantity::Unnamed, _) if self.may_be_acceleration(index) => unclear.push(index),
                (Quantity::Unnamed, _) => open.push(index),
                (Quantity::Unknown, _) => unknown.push(index),
                (Quantity::Unclear, _) => unclear.push(index),
                (Quantity::Speed, false) => left_out.push((self.label(index), "a speed")),
                (Quantity::Position, true) => left_out.push((self.label(index), "a position")),
                (Quantity::Time, _) => left_out.push((self.label(index), "another time")),
                (Quantity::Other(what), _) => left_out.push((self.label(index), what)),
            }
        }
        let doubtful = |columns: &[usize], reason| {
            Err(TrajectoryError::Doubtful {
                line: self.line,
                columns: self.labels(columns),
                reason,
            })
        };
        // A name that nobody knows is that of the axis when no other column can be one.
        if stated.is_empty() && open.is_empty() && unclear.is_empty() && unknown.len() == 1 {
            open.append(&mut unknown);
        }
        unclear.append(&mut unknown);
        unclear.sort_unstable();
        if !unclear.is_empty() {
            return doubtful(&unclear, "may be an axis or another quantity");
        }
        if !stated.is_empty() && !open.is_empty() {
            return doubtful(
                &open,
                "may be an axis or not, while others say what they are",
            );
        }
        let positions = if stated.is_empty() { open } else { stated };
        let origin = |index: &usize| self.names[*index].origin;
        if let Some(first) = positions.first()
            && positions.iter().any(|index| origin(index) != origin(first))
        {
            return doubtful(
                &positions,
                "may be commanded or measured values of one thing",
            );
        }
        if positions.is_empty() {
            let left_out = left_out
                .iter()
                .map(|(label, what)| format!("{label}: {what}"));
            return Err(TrajectoryError::NoAxes {
                line: self.line,
                left_out: left_out.collect(),
            });
        }
        for &index in &positions {
            self.check_name_is_single(index)?;
        }
        Ok((positions, left_out))
    }

    /// Every column that is neither time nor an axis; `known` are reasons that were found before.
    pub(super) fn left_out(
        &self,
        time: usize,
        positions: &[usize],
        known: &[LeftOut],
    ) -> Vec<LeftOut> {
        let others = (0..self.names.len()).filter(|i| *i != time && !positions.contains(i));
        others
            .map(|index| {
                let reason = known.iter().find(|(label, _)| label.number == index + 1);
                (
                    self.label(index),
                    reason.map_or("not chosen", |(_, reason)| reason),
                )
            })
            .collect()
    }

    /// `a` beside a speed.
    fn may_be_acceleration(&self, index: usize) -> bool {
        let text = self.names[index].text.to_lowercase();
        let mut words = text.split(|letter: char| !letter.is_alphanumeric());
        let is_a =
            words.any(|word| word.trim_end_matches(|letter: char| letter.is_ascii_digit()) == "a");
        let is_speed = |name: &Name| match name.quantity {
            Quantity::Unclear => name.text.to_lowercase().contains(['v', 'w']),
            quantity => quantity == Quantity::Speed,
        };
        is_a && self.names.iter().any(is_speed)
    }

    fn check_name_is_single(&self, index: usize) -> Result<(), TrajectoryError> {
        let name = &self.names[index].text;
        let same: Vec<usize> = (0..self.names.len())
            .filter(|&other| self.names[other].text == *name)
            .collect();
        if same.len() > 1 {
            return Err(TrajectoryError::SameName {
                name: name.clone(),
                columns: self.labels(&same),
            });
        }
        Ok(())
    }

    pub(super) fn chosen(&self, wanted: &[String]) -> Result<Vec<usize>, TrajectoryError> {
        let lists = wanted
            .iter()
            .map(|wanted| self.range(wanted, self.names.len()));
        Ok(lists.collect::<Result<Vec<_>, _>>()?.concat())
    }

    pub(super) fn range(&self, wanted: &str, width: usize) -> Result<Vec<usize>, TrajectoryError> {
        let bad = || TrajectoryError::BadRange {
            wanted: wanted.to_owned(),
        };
        let is_name = self.names.iter().any(|name| name.text == wanted);
        let ends = wanted.split_once('-').filter(|_| !is_name);
        let number = |text: &str| text.trim().parse::<usize>().ok();
        match ends.map(|(first, last)| (number(first), number(last))) {
            Some((Some(first), Some(last))) if first <= last => {
                // Both ends first: a range may be longer than any file.
                self.at(last, width)?;
                (first..=last)
                    .map(|number| self.at(number, width))
                    .collect()
            }
            Some((Some(_), _) | (_, Some(_))) => Err(bad()),
            _ => Ok(vec![self.numbered(wanted, width)?]),
        }
    }

    pub(super) fn one(&self, wanted: &str) -> Result<usize, TrajectoryError> {
        self.numbered(wanted, self.names.len())
    }

    /// A column by its name, or by its number from 1.
    pub(super) fn numbered(&self, wanted: &str, width: usize) -> Result<usize, TrajectoryError> {
        // The marks of a comment are no part of a name.
        let name = wanted.trim_start_matches(['%', '#']);
        if let Some(index) = self.names.iter().position(|column| column.text == name) {
            self.check_name_is_single(index)?;
            return Ok(index);
        }
        match wanted.trim().parse() {
            Ok(number) => self.at(number, width),
            Err(_) => Err(self.missing(wanted.to_owned(), width)),
        }
    }

    fn at(&self, number: usize, width: usize) -> Result<usize, TrajectoryError> {
        if number == 0 || number > width {
            return Err(self.missing(number.to_string(), width));
        }
        Ok(number - 1)
    }

    fn missing(&self, wanted: String, width: usize) -> TrajectoryError {
        let names: Vec<&str> = self.names.iter().map(|name| name.text.as_str()).collect();
        let available = if names.is_empty() {
            format!("columns 1 to {width}, without names")
        } else {
            names.join(", ")
        };
        TrajectoryError::NoSuchColumn { wanted, available }
    }
}
