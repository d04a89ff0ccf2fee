//! Gives one drive a new id.

use dyn_can::{Address, Dialect, DriveId, Reply, Request, Revision, ZeroAddress};

use crate::answers::ASKED;
use crate::{Exchange, Heard, LISTEN_US, Script};

/// How long the bus must be quiet before anything is sent: a master that streams is heard in far less.
const QUIET_US: u32 = 200_000;

/// How an assignment ended. Only the first three told the drive its new id.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub enum AssignResult {
    /// The drive answers under its new id.
    Active,
    /// The drive was told and answers under its old id; the new one counts after a power cycle (1.6A, D33). Read the id again then.
    AfterPowerCycle,
    /// The drive was told, but does not answer as its revision promises.
    NotConfirmed,
    /// The drive answered with a data error, and has stored nothing.
    Refused,
    /// Frames were on the bus that nobody here asked for: nothing was sent, or nothing but reads.
    NotQuiet,
    /// Another drive is on the bus, and would take the id too, because it may obey identifier 0 (D2): only reads were sent.
    OtherDrive(DriveId),
    /// More than one drive answers under the old id: only reads were sent.
    SeveralDrives,
    /// A drive already answers under the new id: only reads were sent.
    IdTaken,
    /// No drive answers under the old id: only reads were sent.
    NoDrive,
    /// The length of the drive's parameter group 3 is that of no known revision (D62): only reads were sent.
    UnknownRevision,
    /// The dialect does not allow one of the frames.
    NotAllowed,
}

#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum Step {
    Start,
    Quiet,
    /// Only where the drive is addressed as 0: every id is asked.
    Others(DriveId),
    CheckOld(u8),
    Revision,
    CheckNew,
    Assign,
    ConfirmNew,
    ConfirmOld,
}

/// Gives the drive at `from` the id `to`, after making sure that the bus is quiet, that exactly one drive answers under the old id and
/// none under the new one.
#[derive(Debug)]
pub struct AssignId {
    from: Address,
    to: DriveId,
    dialect: Dialect,
    listen_us: u32,
    step: Step,
}

impl AssignId {
    /// Moves a drive from one id to another. The id is stored in the EEPROM.
    #[must_use]
    pub const fn rename(from: DriveId, to: DriveId) -> Self {
        Self::new(Address::Drive(from), to, Dialect::V1_6A)
    }

    /// Gives a fresh drive, which has id 0, its first id. The drive must be ALONE on the bus: every drive hears
    /// identifier 0, and all of them would take the id (D2, D33). A drive that has an id is looked for first.
    #[must_use]
    pub const fn first_id_of_the_only_drive(to: DriveId) -> Self {
        let dialect = Dialect {
            zero_address: ZeroAddress::LoneFreshDrive,
            ..Dialect::V1_6A
        };
        Self::new(Address::Broadcast, to, dialect)
    }

    const fn new(from: Address, to: DriveId, dialect: Dialect) -> Self {
        Self {
            from,
            to,
            dialect,
            listen_us: LISTEN_US,
            step: Step::Start,
        }
    }

    /// Listens to each answer for so many microseconds: for adapters that hold replies back.
    #[must_use]
    pub const fn listening(self, listen_us: u32) -> Self {
        Self { listen_us, ..self }
    }

    /// The revision that the drive has told, once it was asked.
    #[must_use]
    pub const fn revision(&self) -> Option<Revision> {
        match self.step {
            Step::CheckNew | Step::Assign | Step::ConfirmNew | Step::ConfirmOld => {
                Some(self.dialect.revision)
            }
            _ => None,
        }
    }

    fn ask(&self, request: Request, address: Address) -> Result<Exchange, AssignResult> {
        let ask = Exchange::ask(request, address, &self.dialect);
        ask.map(|ask| ask.counting_answers().listening(self.listen_us))
            .ok_or(AssignResult::NotAllowed)
    }

    fn ask_id(&self, address: Address) -> Result<Exchange, AssignResult> {
        self.ask(Request::ReadDriveId, address)
    }

    /// Goes to a step and asks for an id there.
    fn go_and_ask(&mut self, step: Step, address: Address) -> Result<Exchange, AssignResult> {
        self.step = step;
        self.ask_id(address)
    }

    fn quiet(&mut self, heard: &Heard) -> Result<Exchange, AssignResult> {
        if heard.frames > 0 {
            return Err(AssignResult::NotQuiet);
        }
        match self.from {
            Address::Broadcast => {
                self.go_and_ask(Step::Others(DriveId::MIN), Address::Drive(DriveId::MIN))
            }
            Address::Drive(_) => self.check_old(ASKED),
        }
    }

    fn others(&mut self, asked: DriveId, heard: &Heard) -> Result<Exchange, AssignResult> {
        if heard.answers > 0 {
            return Err(if asked == self.to {
                AssignResult::IdTaken
            } else {
                AssignResult::OtherDrive(asked)
            });
        }
        match DriveId::new(i32::from(asked.get()).saturating_add(1)) {
            Ok(next) => self.go_and_ask(Step::Others(next), Address::Drive(next)),
            Err(_) => self.check_old(ASKED),
        }
    }

    fn check_old(&mut self, left: u8) -> Result<Exchange, AssignResult> {
        self.go_and_ask(Step::CheckOld(left.saturating_sub(1)), self.from)
    }

    fn checked_old(&mut self, left: u8, heard: &Heard) -> Result<Exchange, AssignResult> {
        match (heard.answers, heard.frames) {
            (0, 0) => Err(AssignResult::NoDrive),
            // A drive that has an id answers identifier 0 under its own.
            (1, 1) if left > 0 => self.check_old(left),
            (1, 1) => {
                self.step = Step::Revision;
                self.ask(Request::ReadParamGroup3, self.from)
            }
            (2.., _) => Err(AssignResult::SeveralDrives),
            _ => Err(AssignResult::NotQuiet),
        }
    }

    fn learn_revision(&mut self, heard: &Heard) -> Result<Exchange, AssignResult> {
        let reply = heard.reply_frame;
        let revision =
            reply.and_then(|reply| Revision::from_group3_reply_len(usize::from(reply.len())));
        let revision = revision.ok_or(AssignResult::UnknownRevision)?;
        self.dialect = Dialect {
            zero_address: self.dialect.zero_address,
            ..Dialect::of(revision)
        };
        self.go_and_ask(Step::CheckNew, Address::Drive(self.to))
    }

    fn assign(&mut self) -> Result<Exchange, AssignResult> {
        self.step = Step::Assign;
        let request = Request::AssignDriveId(self.to.into());
        let frame = request.encode(self.from, &self.dialect);
        frame
            .map(|frame| Exchange::tell(frame, self.listen_us))
            .map_err(|_| AssignResult::NotAllowed)
    }

    fn confirmed(&mut self, heard: &Heard) -> Result<Exchange, AssignResult> {
        match heard.reply {
            Some(Reply::DriveId(id)) if id.drive_id() == Some(self.to) => Err(AssignResult::Active),
            None if heard.frames == 0 && self.dialect.revision == Revision::V1_6A => {
                self.go_and_ask(Step::ConfirmOld, self.from)
            }
            _ => Err(AssignResult::NotConfirmed),
        }
    }
}

impl Script for AssignId {
    type Result = AssignResult;

    fn next(&mut self, heard: Heard) -> Result<Exchange, AssignResult> {
        match self.step {
            Step::Start => {
                self.step = Step::Quiet;
                Ok(Exchange::listen(QUIET_US))
            }
            Step::Quiet => self.quiet(&heard),
            Step::Others(asked) => self.others(asked, &heard),
            Step::CheckOld(left) => self.checked_old(left, &heard),
            Step::Revision => self.learn_revision(&heard),
            Step::CheckNew if heard.frames > 0 => Err(AssignResult::IdTaken),
            Step::CheckNew => self.assign(),
            Step::Assign if heard.data_error => Err(AssignResult::Refused),
            Step::Assign => self.go_and_ask(Step::ConfirmNew, Address::Drive(self.to)),
            Step::ConfirmNew => self.confirmed(&heard),
            Step::ConfirmOld if heard.answers > 0 => Err(AssignResult::AfterPowerCycle),
            Step::ConfirmOld => Err(AssignResult::NotConfirmed),
        }
    }

    fn dialect(&self) -> &Dialect {
        &self.dialect
    }
}
