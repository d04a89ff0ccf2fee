//! The documented doubts, one small value.

use dyn_values::Dummy;

/// How to read the manual where it leaves a choice.
///
/// Start from [`Dialect::MANUAL`] and change a field when a measurement on the drive says so.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct Dialect {
    /// How parameters are sent: the table and the sample code disagree (M12, M13).
    pub parameter_form: ParameterForm,
    /// The byte that a function without data sends; the sample code sends another one than the examples.
    pub dummy: Dummy,
    /// What may go to the general id 127, which every drive hears (M24).
    pub general_id: GeneralId,
}

impl Dialect {
    /// The recommended reading of the DYN2 manual A1.8.
    pub const MANUAL: Self = Self {
        parameter_form: ParameterForm::Table,
        dummy: Dummy::MIN,
        general_id: GeneralId::CoordinatedMoves,
    };
}

/// How Set_MainGain ... Set_GearNumber carry their number.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub enum ParameterForm {
    /// As the function table says: one unsigned byte, two for the gear number, which then ends at 16383.
    Table,
    /// As the sample code sends them: the shortest signed form, two bytes from 64 on and three for gears from 8192 on.
    ShortestSigned,
}

/// What may go to the general id.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub enum GeneralId {
    /// Make_LinearLine and Make_CircularArc, the documented use.
    CoordinatedMoves,
    /// Also Turn_ConstSpeed, Square_Wave and Sin_Wave with 0: stop everything.
    Stop,
    /// Any request: commissioning of one drive that is alone on the line, and line monitors.
    LoneDrive,
}
