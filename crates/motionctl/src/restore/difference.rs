//! What differs between the file and a drive.

use comfy_table::Table;
use comfy_table::presets::UTF8_BORDERS_ONLY;
use dyn_can::{GearNumber, StoredDriveId};

use crate::drives::{Parameter, Setting};
use crate::side_effect::SideEffect;

/// A setting that the drive does not have.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) struct Change {
    pub(super) setting: Setting,
    /// `None`: the drive has no such parameter so far.
    pub(super) before: Option<i32>,
}

/// What differs on one drive, in the order in which it is written.
#[derive(Debug, Clone, PartialEq, Eq)]
pub(super) struct Difference {
    pub(super) drive: StoredDriveId,
    /// Number of settings that were compared.
    pub(super) compared: usize,
    pub(super) changes: Vec<Change>,
    pub(super) gear_before: Option<GearNumber>,
    pub(super) gear_after: Option<GearNumber>,
}

impl Difference {
    pub(super) fn is_empty(&self) -> bool {
        self.changes.is_empty()
    }

    /// The place of a change: with another gear number the drive is not the one that was checked any more, and one that has power
    /// takes nothing else.
    pub(super) fn order(change: &Change) -> u8 {
        if SideEffect::switches_servo_on(&change.setting, change.before) {
            2
        } else {
            u8::from(change.setting.parameter == Parameter::GearNumber)
        }
    }
}

/// Every difference with its units.
pub(super) fn table(differences: &[Difference]) -> Table {
    let mut table = Table::new();
    table.load_style(UTF8_BORDERS_ONLY).set_header([
        "drive",
        "setting",
        "in the drive",
        "in the file",
    ]);
    for drive in differences {
        for Change { setting, before } in &drive.changes {
            let parameter = setting.parameter;
            let before = before.map(|before| parameter.in_units(before, drive.gear_before));
            table.add_row([
                drive.drive.to_string(),
                parameter.to_string(),
                before.unwrap_or_else(|| "none".to_owned()),
                parameter.in_units(setting.value, drive.gear_after),
            ]);
        }
    }
    table
}
