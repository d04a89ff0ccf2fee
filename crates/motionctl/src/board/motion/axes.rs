//! Which axis of the board each column of the motion moves.

use board_link::AxisLimits;
use board_link::message::Origin;
use board_settings::{Board, Configs, Settings};
use dyn_can::{DriveId, GearNumber};

use crate::board::error::BoardError;
use crate::recording::AxisAbout;
use crate::station::Needs;
use crate::trajectory::{MotionFile, Plan};

/// A column of the motion.
#[derive(Debug, Clone)]
pub(in crate::board) struct Axis {
    pub(in crate::board) drive: DriveId,
    /// Its place among the axes of the board.
    pub(in crate::board) place: usize,
    pub(in crate::board) gear: GearNumber,
    pub(in crate::board) needs: Needs,
    pub(in crate::board) about: AxisAbout,
}

/// What the settings of the board say.
pub(in crate::board) struct OfBoard {
    pub(in crate::board) drives: Vec<DriveId>,
    pub(in crate::board) limits: Vec<AxisLimits>,
    configs: Configs,
}

impl OfBoard {
    /// The same that the board made of its settings.
    pub(in crate::board) fn new(board: &str, settings: &Settings) -> Result<Self, BoardError> {
        let built = Board::named(board).ok_or_else(|| BoardError::UnknownBoard {
            board: board.to_owned(),
        })?;
        let configs = settings
            .configs(&built)
            .map_err(BoardError::UnreadableSettings)?;
        Ok(Self {
            drives: configs.axes.iter().map(|axis| axis.drive).collect(),
            limits: configs.limits.to_vec(),
            configs,
        })
    }

    /// The limits of the axes where their positions count from there.
    ///
    /// # Errors
    /// [`BoardError::NotHomed`].
    pub(in crate::board) fn limits_from(
        &self,
        origins: &[Origin],
    ) -> Result<Vec<AxisLimits>, BoardError> {
        let axes = self.limits.iter().zip(origins).zip(&self.drives);
        axes.map(|((limits, origin), &drive)| match origin.counts() {
            Some(counts) => Ok(limits.moved_by(counts.into())),
            None => Err(BoardError::NotHomed { drive }),
        })
        .collect()
    }

    /// The columns of a motion with their axes.
    pub(in crate::board) fn axes(
        &self,
        motion: &MotionFile<'_>,
        plan: &Plan,
        cycle_us: u32,
    ) -> Result<Vec<Axis>, BoardError> {
        let drives = self.drives_of(motion)?;
        let gears = motion.gear_numbers().map_err(BoardError::Motion)?;
        let abouts = motion.axes_about(&drives).map_err(BoardError::Motion)?;
        let mut axes = Vec::new();
        for (axis, ((drive, gear), about)) in drives.into_iter().zip(gears).zip(abouts).enumerate()
        {
            let positions: Vec<i32> = plan.rows().map(|row| row[axis]).collect();
            let needs = Needs::of(&positions, gear, cycle_us);
            axes.push(self.axis(drive, gear, needs, about)?);
        }
        Ok(axes)
    }

    /// The axes of these drives, whose gear numbers are expected to be these. What they will need nobody knows, so it is what they may.
    pub(in crate::board) fn axes_of_stream(
        &self,
        drives: &[DriveId],
        gears: &[GearNumber],
        needs: impl Fn(GearNumber) -> Needs,
    ) -> Result<Vec<Axis>, BoardError> {
        let axes = drives.iter().zip(gears);
        axes.map(|(&drive, &gear)| self.axis(drive, gear, needs(gear), AxisAbout::of_drive(drive)))
            .collect()
    }

    fn axis(
        &self,
        drive: DriveId,
        gear: GearNumber,
        needs: Needs,
        about: AxisAbout,
    ) -> Result<Axis, BoardError> {
        let place = self.place(drive)?;
        let actual = self.configs.axes[place].gear;
        if actual != gear {
            return Err(BoardError::Gear {
                drive,
                expected: gear,
                actual,
            });
        }
        Ok(Axis {
            drive,
            place,
            gear,
            needs,
            about,
        })
    }

    /// Those that are named, or all of the board where there is a column for each.
    fn drives_of(&self, motion: &MotionFile<'_>) -> Result<Vec<DriveId>, BoardError> {
        if motion.names_drives() {
            return motion.drives().map_err(BoardError::Motion);
        }
        let axes = motion.axes().map_err(BoardError::Motion)?;
        if axes != self.drives.len() {
            let board = self.drives.clone();
            return Err(BoardError::Drives { axes, board });
        }
        Ok(self.drives.clone())
    }

    fn place(&self, drive: DriveId) -> Result<usize, BoardError> {
        let place = self.drives.iter().position(|known| *known == drive);
        place.ok_or_else(|| BoardError::NoDrive {
            drive,
            board: self.drives.clone(),
        })
    }
}
