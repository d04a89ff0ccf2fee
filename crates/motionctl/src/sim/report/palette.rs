//! Colours by name. A picture carries these values, and the style sheet replaces each by a light or a dark one.

use plotters::style::RGBColor;

/// Text and axes.
pub(super) const INK: RGBColor = RGBColor(0, 0, 1);
/// Lines behind the curves.
pub(super) const GRID: RGBColor = RGBColor(0, 0, 2);
/// Where the application wants the axis.
pub(super) const TARGET: RGBColor = RGBColor(0, 0, 3);
/// Where the sent set-points take the drive.
pub(super) const SENT: RGBColor = RGBColor(0, 0, 4);
/// Where the motor is.
pub(super) const DRIVE: RGBColor = RGBColor(0, 0, 5);
/// Target minus drive.
pub(super) const ERROR: RGBColor = RGBColor(0, 0, 6);
/// Target minus sent.
pub(super) const BACKLOG: RGBColor = RGBColor(0, 0, 7);
/// Age of the status.
pub(super) const STATUS_AGE: RGBColor = RGBColor(0, 0, 8);
/// Age of the position.
pub(super) const POSITION_AGE: RGBColor = RGBColor(0, 0, 9);
/// Load and histogram.
pub(super) const BUS: RGBColor = RGBColor(0, 0, 10);
/// A commanded fault.
pub(super) const CAUSE: RGBColor = RGBColor(0, 0, 11);
/// A latched fault, a late cycle.
pub(super) const FAULT: RGBColor = RGBColor(0, 0, 12);
/// Something noticed.
pub(super) const NOTICE: RGBColor = RGBColor(0, 0, 13);
/// A change of state, a phase.
pub(super) const STATE: RGBColor = RGBColor(0, 0, 14);

/// Name in the style sheet and colour.
const NAMES: [(&str, RGBColor); 14] = [
    ("ink", INK),
    ("grid", GRID),
    ("target", TARGET),
    ("sent", SENT),
    ("drive", DRIVE),
    ("error", ERROR),
    ("backlog", BACKLOG),
    ("status-age", STATUS_AGE),
    ("position-age", POSITION_AGE),
    ("bus", BUS),
    ("cause", CAUSE),
    ("fault", FAULT),
    ("notice", NOTICE),
    ("state", STATE),
];

/// The rules that give every colour of a picture its value of the style sheet.
pub(super) fn rules() -> String {
    let rule = |(name, RGBColor(r, g, b)): &(&str, RGBColor)| {
        let hex = format!("#{r:02X}{g:02X}{b:02X}");
        format!(
            "svg [stroke=\"{hex}\"]{{stroke:var(--{name})}}svg [fill=\"{hex}\"]{{fill:var(--{name})}}\n"
        )
    };
    NAMES.iter().map(rule).collect()
}
