//! The drives' bus: `embedded_can::nb::Can` over the unbuffered bxCAN driver.
//!
//! Unbuffered on purpose: the three transmit mailboxes are the only queue, so what the master hands over next waits for three frames
//! at most, and the master always knows what was not sent. The vendor driver shows neither bus-off nor receive overruns and would
//! recover from bus-off by itself and send the old frames afterwards; both are handled here, in the controller's registers
//! (RM0090, section 32.9).

use core::convert::Infallible;
use core::fmt;

use can_motion::Progress;
use embassy_futures::select::select;
use embassy_stm32::can::enums::{BusError as LineError, TryReadError};
use embassy_stm32::can::filter::{Mask16, Mask32};
use embassy_stm32::can::frame::Header;
use embassy_stm32::can::{Can, CanRx, CanTx, Fifo, Frame, StandardId, TryWriteError};
use embassy_stm32::pac;
use embassy_time::{Duration, Timer};
use embedded_can::ErrorKind;

/// Low bits of an identifier: the function code. CAN specification 1.6A, "CAN ID".
const FUNCTION_CODE_MASK: StandardId = standard_id(0x1F);
/// Function code of the frames a drive sends unasked: alarm and data error. CAN specification 1.6A, `Drive_Error`.
const DRIVE_ERROR: StandardId = standard_id(0x1D);
const ANY: StandardId = StandardId::ZERO;

/// Alarms have a receive FIFO of their own, so that a burst of replies cannot push one out.
const ALARM_FIFO: Fifo = Fifo::Fifo1;
const REPLY_FIFO: Fifo = Fifo::Fifo0;

const RECEIVE_FIFOS: usize = 2;
const MAILBOXES: usize = 3;
/// Most data bytes of a frame; a data length code of 9..15 on the wire also means 8.
const MAX_DATA_BYTES: u8 = 8;
/// How often [`Bus::joined`] looks; the join itself takes 11 recessive bits.
const JOIN_POLL: Duration = Duration::from_micros(100);

/// An identifier known when the firmware is built; one that does not fit 11 bits stops the build when used in a constant.
const fn standard_id(raw: u16) -> StandardId {
    match StandardId::new(raw) {
        Some(id) => id,
        None => panic!("a standard identifier has 11 bits"),
    }
}

/// What went wrong on the bus.
#[derive(Clone, Copy, Debug, PartialEq, Eq, defmt::Format)]
#[non_exhaustive]
pub(crate) enum BusError {
    /// More than five equal bits where stuffing was expected.
    Stuff,
    /// A fixed bit had the wrong level.
    Form,
    /// Nobody acknowledged a transmitted frame.
    Acknowledge,
    /// The level read back was not the level sent.
    Bit,
    /// The checksum of a received frame was wrong.
    Crc,
    /// The receive FIFO of this number, 0 or 1, was full and a frame was lost: read faster.
    Overrun(usize),
    /// The controller is off the bus: nothing was queued. [`Bus::recover`] brings it back.
    BusOff,
    /// The controller gave an error code without a meaning.
    Unspecified,
}

impl fmt::Display for BusError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Stuff => f.write_str("stuff error on the bus"),
            Self::Form => f.write_str("form error on the bus"),
            Self::Acknowledge => f.write_str(
                "no node acknowledged the frame: check wiring, termination and the drives' supply",
            ),
            Self::Bit => f.write_str("bit error on the bus"),
            Self::Crc => f.write_str("checksum error on the bus"),
            Self::Overrun(fifo) => write!(f, "receive FIFO {fifo} overrun: a frame was lost"),
            Self::BusOff => f.write_str("the controller is bus-off: recover it before sending"),
            Self::Unspecified => f.write_str("unspecified bus error"),
        }
    }
}

impl core::error::Error for BusError {}

impl embedded_can::Error for BusError {
    fn kind(&self) -> ErrorKind {
        match self {
            Self::Stuff => ErrorKind::Stuff,
            Self::Form => ErrorKind::Form,
            Self::Acknowledge => ErrorKind::Acknowledge,
            Self::Bit => ErrorKind::Bit,
            Self::Crc => ErrorKind::Crc,
            Self::Overrun(_) => ErrorKind::Overrun,
            Self::BusOff | Self::Unspecified => ErrorKind::Other,
        }
    }
}

impl From<LineError> for BusError {
    fn from(error: LineError) -> Self {
        match error {
            LineError::Stuff => Self::Stuff,
            LineError::Form => Self::Form,
            LineError::Acknowledge => Self::Acknowledge,
            LineError::BitRecessive | LineError::BitDominant => Self::Bit,
            LineError::Crc => Self::Crc,
            LineError::Software => Self::Unspecified,
        }
    }
}

/// Fault confinement state of the controller (ISO 11898-1).
#[derive(Clone, Copy, Debug, PartialEq, Eq, defmt::Format)]
pub(crate) enum FaultState {
    /// Normal: both error counters below 128.
    ErrorActive,
    /// One error counter at 128 or above: the controller takes part but can no longer enforce its errors.
    ErrorPassive,
    /// The transmit error counter went over 255, and the controller has not been brought back since.
    BusOff,
}

/// Where the way back from bus-off stands.
#[derive(Clone, Copy, PartialEq, Eq)]
enum Recovery {
    /// Not under way.
    Idle,
    /// Mailboxes being emptied, initialisation requested.
    Initialising,
    /// Waiting for 128 times 11 recessive bits.
    Rejoining,
}

/// The bus with its controller.
pub(crate) struct Bus {
    transmitter: CanTx<'static>,
    receiver: CanRx<'static>,
    registers: pac::can::Can,
    recovery: Recovery,
    /// Held because dropping it resets the controller.
    _controller: Can<'static>,
}

impl Bus {
    /// Takes over a controller whose bit timing is set and which still sleeps, and lets it join the bus; [`Self::joined`] says when it has.
    /// `registers` must be those of `controller`.
    pub(crate) fn new(mut controller: Can<'static>, registers: pac::can::Can) -> Self {
        set_filters(&mut controller);
        // First in, first out: by identifier, a poll of a low drive would overtake the set-points of the higher ones.
        controller.set_tx_fifo_scheduling(true);
        // The driver's own `enable` switches automatic bus-off management on, and old set-points would go out after a recovery.
        registers.mcr().modify(|mcr| {
            mcr.set_abom(false);
            mcr.set_sleep(false);
            mcr.set_inrq(false);
        });
        let (transmitter, receiver) = controller.split();
        Self {
            transmitter,
            receiver,
            registers,
            recovery: Recovery::Idle,
            _controller: controller,
        }
    }

    /// Waits until the controller takes part in the traffic, that is until it has seen 11 recessive bits.
    /// Waits for ever on a bus that is held dominant or has no transceiver.
    pub(crate) async fn joined(&self) {
        loop {
            let status = self.registers.msr().read();
            if !status.slak() && !status.inak() {
                return;
            }
            Timer::after(JOIN_POLL).await;
        }
    }

    /// Waits until servicing the bus again has a purpose: until a received frame can be read or, when a frame waits for
    /// room, until a mailbox is free. Cancelling it loses nothing.
    pub(crate) async fn serviceable(&mut self, progress: Progress) {
        let arrived = self.receiver.wait_not_empty();
        match progress {
            Progress::Idle => arrived.await,
            Progress::Blocked => {
                select(arrived, self.transmitter.flush_any()).await;
            }
        }
    }

    /// The fault confinement state now.
    pub(crate) fn fault_state(&self) -> FaultState {
        let errors = self.registers.esr().read();
        if errors.boff() || self.recovery != Recovery::Idle {
            FaultState::BusOff
        } else if errors.epvf() {
            FaultState::ErrorPassive
        } else {
            FaultState::ErrorActive
        }
    }

    /// One step of the way back from bus-off, to be called every cycle until it returns `Ok`; `Ok` at once when there is nothing to do.
    /// Frames still in the mailboxes are thrown away: nobody knows which of them went out. On an idle bus it takes 1408 bit times.
    pub(crate) fn recover(&mut self) -> nb::Result<(), Infallible> {
        match self.recovery {
            Recovery::Idle if !self.registers.esr().read().boff() => return Ok(()),
            Recovery::Idle => {
                self.discard_pending();
                self.registers.mcr().modify(|mcr| mcr.set_inrq(true));
                self.recovery = Recovery::Initialising;
            }
            Recovery::Initialising => {
                if self.transmitter.is_idle() && self.registers.msr().read().inak() {
                    self.registers.mcr().modify(|mcr| mcr.set_inrq(false));
                    self.recovery = Recovery::Rejoining;
                }
            }
            Recovery::Rejoining => {
                if !self.registers.esr().read().boff() && !self.registers.msr().read().inak() {
                    self.recovery = Recovery::Idle;
                    return Ok(());
                }
            }
        }
        Err(nb::Error::WouldBlock)
    }

    /// Asks the controller to give up every frame in the mailboxes.
    ///
    /// The driver's `abort` also tells whether the frame went out, but its transmit interrupt clears the flag that it reads; here the
    /// answer is not used.
    fn discard_pending(&mut self) {
        // Writing 0 to the other bits of this register changes nothing.
        self.registers.tsr().write(|tsr| {
            for mailbox in 0..MAILBOXES {
                tsr.set_abrq(mailbox, true);
            }
        });
    }

    /// Whether a receive FIFO lost a frame since the last call; the mark is cleared.
    ///
    /// It must be asked before each read, because the driver clears the mark when it releases a frame; an overrun in the microsecond
    /// between the two is not seen.
    fn take_overrun(&mut self) -> Option<usize> {
        let fifo = (0..RECEIVE_FIFOS).find(|&fifo| self.registers.rfr(fifo).read().fovr())?;
        self.registers.rfr(fifo).write(|rfr| rfr.set_fovr(true));
        Some(fifo)
    }
}

impl embedded_can::nb::Can for Bus {
    type Frame = Frame;
    type Error = BusError;

    /// Queues a frame in a free mailbox, to go out after those already there.
    ///
    /// `WouldBlock`: all mailboxes are taken, nothing was queued. `BusOff`: nothing was queued either. With first in, first out no frame
    /// is ever displaced; should the controller be set otherwise, the displaced frame comes back.
    fn transmit(&mut self, frame: &Frame) -> nb::Result<Option<Frame>, BusError> {
        if self.fault_state() == FaultState::BusOff {
            return Err(nb::Error::Other(BusError::BusOff));
        }
        match self.transmitter.try_write(frame) {
            Ok(status) => Ok(status.dequeued_frame().copied()),
            Err(TryWriteError::Full) => Err(nb::Error::WouldBlock),
        }
    }

    /// The oldest received frame, replies first. Errors come once each and interleaved; read on until `WouldBlock`.
    fn receive(&mut self) -> nb::Result<Frame, BusError> {
        if let Some(fifo) = self.take_overrun() {
            return Err(nb::Error::Other(BusError::Overrun(fifo)));
        }
        match self.receiver.try_read() {
            Ok(envelope) => Ok(with_valid_length(envelope.frame)),
            Err(TryReadError::Empty) => Err(nb::Error::WouldBlock),
            Err(TryReadError::BusError(error)) => Err(nb::Error::Other(error.into())),
        }
    }
}

/// Alarm frames to their FIFO, all other standard data frames to the other. Nothing passes out of reset, and extended and remote frames
/// are not part of the protocol.
fn set_filters(controller: &mut Can<'static>) {
    let mut alarms = Mask32::frames_with_std_id(DRIVE_ERROR, FUNCTION_CODE_MASK);
    alarms.data_frames_only();
    let mut others = Mask16::frames_with_std_id(ANY, ANY);
    others.data_frames_only();
    // An alarm passes both: a 32-bit filter goes before a 16-bit one (RM0090, section 32.7.4), whatever their numbers.
    controller
        .modify_filters()
        .enable_bank(0, ALARM_FIFO, alarms)
        .enable_bank(1, REPLY_FIFO, [others, others]);
}

/// The frame with a length of at most 8: the driver passes a data length code of 9..15 on, and reading the data of such a frame panics.
fn with_valid_length(frame: Frame) -> Frame {
    let header = frame.header();
    if header.len() <= MAX_DATA_BYTES {
        return frame;
    }
    let header = Header::new(*header.id(), MAX_DATA_BYTES, header.rtr());
    // The raw buffer has exactly 8 bytes, the only length `new` checks.
    Frame::new(header, frame.raw_data()).unwrap_or(frame)
}
