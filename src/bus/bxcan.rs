//! The bus over bxCAN, the controller of the STM32F4.
//!
//! The vendor driver shows neither bus-off nor receive overruns and would recover from bus-off by itself and send the old frames
//! afterwards; both are handled here, in the controller's registers (RM0090, section 32.9).

use core::convert::Infallible;

use can_motion::Progress;
use embassy_futures::select::select;
use embassy_stm32::can::enums::TryReadError;
use embassy_stm32::can::filter::{Mask16, Mask32};
use embassy_stm32::can::{Can, CanRx, CanTx, Fifo, Frame, TryWriteError};
use embassy_stm32::pac;
use embassy_time::{Duration, Timer};
use embedded_can::StandardId;

use super::{BusError, DRIVE_ERROR, FUNCTION_CODE_MASK, FaultState, with_valid_length};
use crate::transmit_places::{PLACES, RETRY_CYCLES, TransmitPlaces};

const ANY: StandardId = StandardId::ZERO;

/// Alarms have a receive FIFO of their own, so that a burst of replies cannot push one out.
const ALARM_FIFO: Fifo = Fifo::Fifo1;
const REPLY_FIFO: Fifo = Fifo::Fifo0;

const RECEIVE_FIFOS: usize = 2;
/// How often [`Bus::joined`] looks; the join itself takes 11 recessive bits.
const JOIN_POLL: Duration = Duration::from_micros(100);

/// How often [`Bus::take_back`] looks whether the controller has given a frame up.
const ABORT_LOOKS: usize = 8;

/// Where the way back from a failure stands.
#[derive(Clone, Copy, PartialEq, Eq)]
enum Recovery {
    /// Not under way.
    Idle,
    /// Mailboxes being emptied because nobody acknowledged; the next attempt comes after this many cycles.
    Pausing(u32),
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
    places: TransmitPlaces<Frame>,
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
            places: TransmitPlaces::new(),
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

    /// Looks after the frames in the mailboxes, once a cycle, and tells the state of the controller.
    pub(crate) fn check(&mut self) -> FaultState {
        if self.places.pass_cycle(self.occupied())
            && self.recovery == Recovery::Idle
            && !self.is_bus_off()
        {
            self.discard_pending();
            self.recovery = Recovery::Pausing(RETRY_CYCLES);
        }
        self.fault_state()
    }

    fn occupied(&self) -> [bool; PLACES] {
        let status = self.registers.tsr().read();
        core::array::from_fn(|mailbox| !status.tme(mailbox))
    }

    /// Takes back the frame that was queued last. The one that goes next stays: it may be on the wire already, and what became of it
    /// could not be told. So at most one frame goes out after the last that comes back.
    pub(crate) fn take_back(&mut self) -> Option<Frame> {
        // The driver's interrupt would clear the mark that says whether the frame went out.
        cortex_m::interrupt::free(|_| {
            let (mailbox, frame) = self.places.last_behind_another(self.occupied())?;
            // Writing 0 to the other bits of this register changes nothing.
            self.registers
                .tsr()
                .write(|tsr| tsr.set_abrq(mailbox, true));
            // A frame that waits is given up within a few clocks; one that has come onto the wire in this very moment is not.
            (0..ABORT_LOOKS)
                .map(|_| self.registers.tsr().read())
                .find(|status| status.tme(mailbox))
                .filter(|status| !status.txok(mailbox))?;
            Some(frame)
        })
    }

    fn is_bus_off(&self) -> bool {
        self.registers.esr().read().boff()
    }

    fn fault_state(&self) -> FaultState {
        let errors = self.registers.esr().read();
        match self.recovery {
            Recovery::Pausing(_) if !errors.boff() => FaultState::Stuck,
            Recovery::Idle if !errors.boff() && errors.epvf() => FaultState::ErrorPassive,
            Recovery::Idle if !errors.boff() => FaultState::ErrorActive,
            _ => FaultState::BusOff,
        }
    }

    /// One step of the way back from a failure, to be called every cycle until it returns `Ok`; `Ok` at once when there is nothing to do.
    /// Frames still in the mailboxes are thrown away: nobody knows which of them went out. Out of bus-off it takes 1408 bit times on
    /// an idle bus.
    pub(crate) fn recover(&mut self) -> nb::Result<(), Infallible> {
        match self.recovery {
            Recovery::Idle if !self.is_bus_off() => return Ok(()),
            Recovery::Pausing(cycles) if !self.is_bus_off() => {
                if cycles == 0 && self.transmitter.is_idle() {
                    self.recovery = Recovery::Idle;
                    return Ok(());
                }
                self.recovery = Recovery::Pausing(cycles.saturating_sub(1));
            }
            Recovery::Idle | Recovery::Pausing(_) => {
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
                if !self.is_bus_off() && !self.registers.msr().read().inak() {
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
            for mailbox in 0..PLACES {
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
    /// `WouldBlock`: all mailboxes are taken, nothing was queued. `BusOff`: the controller is down, nothing was queued either. With first in, first out no frame
    /// is ever displaced; should the controller be set otherwise, the displaced frame comes back.
    fn transmit(&mut self, frame: &Frame) -> nb::Result<Option<Frame>, BusError> {
        if self.recovery != Recovery::Idle || self.is_bus_off() {
            return Err(nb::Error::Other(BusError::BusOff));
        }
        match self.transmitter.try_write(frame) {
            Ok(status) => {
                self.places.note_queued(status.mailbox() as usize, *frame);
                Ok(status.dequeued_frame().copied())
            }
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
