//! Gives one drive a new id.

use dyn_can::{Address, Dialect, DriveId, Reply, Request, Revision, ZeroAddress};

use crate::{Exchange, Heard, LISTEN_US, Script};

/// How an assignment ended.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub enum AssignResult {
    /// The drive answers under its new id.
    Active,
    /// The drive was told; it answers under its new id after a power cycle (1.6A, D33). Read the id again then.
    AfterPowerCycle,
    /// A drive already answers under the new id: nothing was sent.
    IdTaken,
    /// No drive answers under the old id: nothing was sent.
    NoDrive,
    /// The drive answered with a data error.
    Refused,
    /// The drive was told, but does not answer under its new id although its revision promises it.
    NotConfirmed,
    /// The dialect does not allow one of the frames.
    NotAllowed,
}

#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum Step {
    Start,
    CheckOld,
    CheckNew,
    Assign,
    Confirm,
}

/// Gives the drive at `from` the id `to`, after making sure that the one answers and the other does not.
#[derive(Debug)]
pub struct AssignId {
    from: Address,
    to: DriveId,
    dialect: Dialect,
    step: Step,
}

impl AssignId {
    /// Moves a drive from one id to another. The id is stored in the EEPROM.
    #[must_use]
    pub const fn rename(from: DriveId, to: DriveId, revision: Revision) -> Self {
        Self::new(Address::Drive(from), to, Dialect::of(revision))
    }

    /// Gives a fresh drive, which has id 0, its first id. The drive must be ALONE on the bus: every drive hears
    /// identifier 0, and all of them would take the id (D2, D33).
    #[must_use]
    pub const fn first_id_of_the_only_drive(to: DriveId, revision: Revision) -> Self {
        let dialect = Dialect {
            zero_address: ZeroAddress::LoneFreshDrive,
            ..Dialect::of(revision)
        };
        Self::new(Address::Broadcast, to, dialect)
    }

    const fn new(from: Address, to: DriveId, dialect: Dialect) -> Self {
        Self {
            from,
            to,
            dialect,
            step: Step::Start,
        }
    }

    fn ask_id(&self, address: Address) -> Result<Exchange, AssignResult> {
        Exchange::ask(Request::ReadDriveId, address, &self.dialect).ok_or(AssignResult::NotAllowed)
    }

    fn assign(&self) -> Result<Exchange, AssignResult> {
        let request = Request::AssignDriveId(self.to.into());
        let frame = request.encode(self.from, &self.dialect);
        frame
            .map(|frame| Exchange::tell(frame, LISTEN_US))
            .map_err(|_| AssignResult::NotAllowed)
    }
}

impl Script for AssignId {
    type Result = AssignResult;

    fn next(&mut self, heard: Heard) -> Result<Exchange, AssignResult> {
        let answered = heard.reply_len.is_some();
        let (step, exchange) = match self.step {
            Step::Start => (Step::CheckOld, self.ask_id(self.from)),
            Step::CheckOld if !answered => (self.step, Err(AssignResult::NoDrive)),
            Step::CheckOld => (Step::CheckNew, self.ask_id(Address::Drive(self.to))),
            Step::CheckNew if answered => (self.step, Err(AssignResult::IdTaken)),
            Step::CheckNew => (Step::Assign, self.assign()),
            Step::Assign if heard.data_error => (self.step, Err(AssignResult::Refused)),
            Step::Assign => (Step::Confirm, self.ask_id(Address::Drive(self.to))),
            Step::Confirm => (self.step, Err(self.conclude(heard.reply))),
        };
        self.step = step;
        exchange
    }

    fn dialect(&self) -> &Dialect {
        &self.dialect
    }
}

impl AssignId {
    fn conclude(&self, reply: Option<Reply>) -> AssignResult {
        match (reply, self.dialect.revision) {
            (Some(Reply::DriveId(id)), _) if id.drive_id() == Some(self.to) => AssignResult::Active,
            (None, Revision::V1_6A) => AssignResult::AfterPowerCycle,
            _ => AssignResult::NotConfirmed,
        }
    }
}
