//! Which byte of a number comes first (D18): one probe on a drive whose shaft is free.

use dyn_can::{
    Address, Amplitude, ByteOrder, DataFrame, Dialect, DriveId, FrequencyHz, FunctionCode, Request,
    Revision, ServoSwitch,
};

use crate::{Exchange, Heard, LISTEN_US, Script};

/// What the probe found.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub enum ByteOrderResult {
    /// Exactly one of the two amplitudes was refused: this is the order.
    Order(ByteOrder),
    /// Both or none were refused: do not move this drive before the doubt is settled.
    Undecided,
    /// The dialect does not allow one of the frames.
    NotAllowed,
}

/// Amplitude 4097 (refused) when the most significant byte comes first, 272 (accepted) otherwise.
const REFUSED_IF_MSB_FIRST: [u8; 2] = [0x10, 0x01];
/// The other way round.
const REFUSED_IF_LSB_FIRST: [u8; 2] = [0x01, 0x10];

/// Disables the servo, sets the wave frequency to 0 so that nothing can move, and offers two amplitudes of which one is
/// out of range. Not tried on a drive yet.
#[derive(Debug)]
pub struct ByteOrderProbe {
    drive: DriveId,
    dialect: Dialect,
    listen_us: u32,
    step: u8,
    msb_first_refused: bool,
    lsb_first_refused: bool,
}

impl ByteOrderProbe {
    /// A probe of one drive. Its shaft must be free: the servo is disabled and stays so.
    #[must_use]
    pub const fn with_free_shaft(drive: DriveId, revision: Revision) -> Self {
        Self {
            drive,
            dialect: Dialect::of(revision),
            listen_us: LISTEN_US,
            step: 0,
            msb_first_refused: false,
            lsb_first_refused: false,
        }
    }

    /// Listens to each answer for so many microseconds: for adapters that hold replies back.
    #[must_use]
    pub const fn listening(self, listen_us: u32) -> Self {
        Self { listen_us, ..self }
    }

    fn tell(&self, request: Request) -> Result<Exchange, ByteOrderResult> {
        let frame = request.encode(Address::Drive(self.drive), &self.dialect);
        frame
            .map(|frame| Exchange::tell(frame, self.listen_us))
            .map_err(|_| ByteOrderResult::NotAllowed)
    }

    fn offer(&self, amplitude: [u8; 2]) -> Result<Exchange, ByteOrderResult> {
        let id = self.drive.can_id(FunctionCode::SquareWave);
        let frame = DataFrame::new(id, &amplitude);
        frame
            .map(|frame| Exchange::tell(frame, self.listen_us))
            .map_err(|_| ByteOrderResult::NotAllowed)
    }
}

impl Script for ByteOrderProbe {
    type Result = ByteOrderResult;

    fn next(&mut self, heard: Heard) -> Result<Exchange, ByteOrderResult> {
        self.step += 1;
        match self.step {
            1 => self.tell(Request::ServoDisable(ServoSwitch::Disable)),
            2 => self.tell(Request::SsFrequency(FrequencyHz::MIN)),
            3 => self.offer(REFUSED_IF_MSB_FIRST),
            4 => {
                self.msb_first_refused = heard.data_error;
                self.offer(REFUSED_IF_LSB_FIRST)
            }
            5 => {
                self.lsb_first_refused = heard.data_error;
                self.tell(Request::SquareWave(Amplitude::MIN))
            }
            _ => Err(match (self.msb_first_refused, self.lsb_first_refused) {
                (true, false) => ByteOrderResult::Order(ByteOrder::MsbFirst),
                (false, true) => ByteOrderResult::Order(ByteOrder::LsbFirst),
                _ => ByteOrderResult::Undecided,
            }),
        }
    }

    fn dialect(&self) -> &Dialect {
        &self.dialect
    }
}
