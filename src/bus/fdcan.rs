//! The bus over FDCAN in classic mode, the controller of the STM32G4.
//!
//! The vendor driver only waits: each of its futures is polled once, and pending means that there was nothing to read or no room. It
//! does not show bus-off and lost frames, which are in the controller's registers (RM0440, section 44.4).

use core::convert::Infallible;

use can_motion::Progress;
use embassy_futures::poll_once;
use embassy_futures::select::{Either, select};
use embassy_stm32::can::enums::BusError as LineError;
use embassy_stm32::can::filter::{Action, FilterType, StandardFilter, StandardFilterSlot};
use embassy_stm32::can::frame::{Envelope, Frame};
use embassy_stm32::can::{CanConfigurator, CanRx, CanTx, Properties, config};
use embassy_stm32::pac;
use embassy_stm32::pac::can::vals::Act;
use embassy_time::{Duration, Timer};
use embedded_can::StandardId;

use super::{BusError, DRIVE_ERROR, FUNCTION_CODE_MASK, FaultState, with_valid_length};
use crate::transmit_places::{PLACES, RETRY_CYCLES, TransmitPlaces};

const RECEIVE_FIFOS: usize = 2;
/// How often [`Bus::joined`] looks; the join itself takes 11 recessive bits.
const JOIN_POLL: Duration = Duration::from_micros(100);
/// How often a frame that waits for room is tried again: the driver tells nobody when a place becomes free. Three set-points take
/// twice as long at 1 Mbit/s, so the wire never waits.
const REFILL: Duration = Duration::from_micros(100);

/// Where the way back from a failure stands.
#[derive(Clone, Copy, PartialEq, Eq)]
enum Recovery {
    /// Not under way.
    Idle,
    /// Frames being taken back because nobody acknowledged; the next attempt comes after this many cycles.
    Pausing(u32),
    /// Waiting for 128 times 11 recessive bits.
    Rejoining,
}

/// The bus with its controller.
pub(crate) struct Bus {
    transmitter: CanTx<'static>,
    receiver: CanRx<'static>,
    registers: pac::can::Fdcan,
    /// What came while [`Self::serviceable`] waited.
    received: Option<Result<Envelope, LineError>>,
    recovery: Recovery,
    places: TransmitPlaces<()>,
    /// Held because dropping it resets the controller.
    _properties: Properties,
}

impl Bus {
    /// Takes over a controller whose bit timing is set, and lets it join the bus; [`Self::joined`] says when it has.
    /// `registers` must be those of `controller`.
    pub(crate) fn new(
        mut controller: CanConfigurator<'static>,
        registers: pac::can::Fdcan,
    ) -> Self {
        set_filters(&controller);
        let only_matching = config::GlobalFilter::default()
            .set_handle_standard_frames(config::NonMatchingFilter::Reject)
            .set_handle_extended_frames(config::NonMatchingFilter::Reject)
            .set_reject_remote_standard_frames(true)
            .set_reject_remote_extended_frames(true);
        let mut setup = controller
            .config()
            .set_frame_transmit(config::FrameTransmissionConfig::ClassicCanOnly)
            .set_global_filter(only_matching);
        // First in, first out: by identifier, a poll of a low drive would overtake the set-points of the higher ones.
        setup.tx_buffer_mode = config::TxBufferMode::Fifo;
        setup.automatic_bus_off_recovery = false;
        controller.set_config(setup);
        let (transmitter, receiver, properties) = controller.into_normal_mode().split();
        Self {
            transmitter,
            receiver,
            registers,
            received: None,
            recovery: Recovery::Idle,
            places: TransmitPlaces::new(),
            _properties: properties,
        }
    }

    /// Waits until the controller takes part in the traffic, that is until it has seen 11 recessive bits.
    /// Waits for ever on a bus that is held dominant or has no transceiver.
    pub(crate) async fn joined(&self) {
        while self.registers.cccr().read().init() || self.registers.psr().read().act() == Act::SYNC
        {
            Timer::after(JOIN_POLL).await;
        }
    }

    /// Waits until servicing the bus again has a purpose: until a received frame can be read or, when a frame waits for
    /// room, until there may be some. Cancelling it loses nothing.
    pub(crate) async fn serviceable(&mut self, progress: Progress) {
        if self.received.is_some() {
            return;
        }
        let arrived = self.receiver.read();
        self.received = match progress {
            Progress::Idle => Some(arrived.await),
            Progress::Blocked => match select(arrived, Timer::after(REFILL)).await {
                Either::First(received) => Some(received),
                Either::Second(()) => None,
            },
        };
    }

    /// Looks after the frames that wait, once a cycle, and tells the state of the controller.
    pub(crate) fn check(&mut self) -> FaultState {
        let pending = self.registers.txbrp().read();
        let occupied = core::array::from_fn(|place| pending.trp(place));
        if self.places.pass_cycle(occupied) && self.recovery == Recovery::Idle && !self.is_bus_off()
        {
            self.discard_pending();
            self.recovery = Recovery::Pausing(RETRY_CYCLES);
        }
        let status = self.registers.psr().read();
        match self.recovery {
            Recovery::Pausing(_) if !status.bo() => FaultState::Stuck,
            Recovery::Idle if !status.bo() && status.ep() => FaultState::ErrorPassive,
            Recovery::Idle if !status.bo() => FaultState::ErrorActive,
            _ => FaultState::BusOff,
        }
    }

    /// Takes nothing back: this controller cannot cancel single frames of its FIFO (RM0440, section 44.3.6). The three frames that it
    /// holds still go out.
    pub(crate) const fn take_back(&mut self) -> Option<Frame> {
        None
    }

    fn is_bus_off(&self) -> bool {
        self.registers.psr().read().bo()
    }

    /// One step of the way back from a failure, to be called every cycle until it returns `Ok`; `Ok` at once when there is nothing to do.
    /// Frames that still wait are thrown away: nobody knows which of them went out. Out of bus-off it takes 1408 bit times on an
    /// idle bus.
    pub(crate) fn recover(&mut self) -> nb::Result<(), Infallible> {
        match self.recovery {
            Recovery::Idle if !self.is_bus_off() => return Ok(()),
            Recovery::Pausing(cycles) if !self.is_bus_off() => {
                if cycles == 0 && self.registers.txbrp().read().0 == 0 {
                    self.recovery = Recovery::Idle;
                    return Ok(());
                }
                self.recovery = Recovery::Pausing(cycles.saturating_sub(1));
            }
            Recovery::Idle | Recovery::Pausing(_) => {
                self.discard_pending();
                // Bus-off has set it; taking it back starts the sequence (RM0440, section 44.3.2).
                self.registers
                    .cccr()
                    .modify(|control| control.set_init(false));
                self.recovery = Recovery::Rejoining;
            }
            Recovery::Rejoining => {
                if !self.is_bus_off() && !self.registers.cccr().read().init() {
                    self.recovery = Recovery::Idle;
                    return Ok(());
                }
            }
        }
        Err(nb::Error::WouldBlock)
    }

    /// Asks the controller to give up every frame that waits.
    fn discard_pending(&mut self) {
        self.registers.txbcr().write(|cancel| {
            for place in 0..PLACES {
                cancel.set_cr(place, true);
            }
        });
    }

    /// Whether a receive FIFO lost a frame since the last call; the mark is cleared.
    fn take_overrun(&mut self) -> Option<usize> {
        let flags = self.registers.ir().read();
        let fifo = (0..RECEIVE_FIFOS).find(|&fifo| flags.rfl(fifo))?;
        // Writing 0 to the other bits of this register changes nothing.
        self.registers.ir().write(|flags| flags.set_rfl(fifo, true));
        Some(fifo)
    }
}

impl embedded_can::nb::Can for Bus {
    type Frame = Frame;
    type Error = BusError;

    /// Queues a frame in a free place, to go out after those already there.
    ///
    /// `WouldBlock`: all places are taken, nothing was queued. `BusOff`: the controller is down, nothing was queued either. With first
    /// in, first out no frame is ever displaced; should the controller be set otherwise, the displaced frame comes back.
    fn transmit(&mut self, frame: &Frame) -> nb::Result<Option<Frame>, BusError> {
        if self.recovery != Recovery::Idle || self.is_bus_off() {
            return Err(nb::Error::Other(BusError::BusOff));
        }
        let place = usize::from(self.registers.txfqs().read().tfqpi());
        match poll_once(self.transmitter.write(frame)) {
            core::task::Poll::Ready(displaced) => {
                self.places.note_queued(place, ());
                Ok(displaced)
            }
            core::task::Poll::Pending => Err(nb::Error::WouldBlock),
        }
    }

    /// The oldest received frame, replies first. Errors come once each and interleaved; read on until `WouldBlock`.
    fn receive(&mut self) -> nb::Result<Frame, BusError> {
        if let Some(fifo) = self.take_overrun() {
            return Err(nb::Error::Other(BusError::Overrun(fifo)));
        }
        let received = match self.received.take() {
            Some(received) => received,
            None => match poll_once(self.receiver.read()) {
                core::task::Poll::Ready(received) => received,
                core::task::Poll::Pending => return Err(nb::Error::WouldBlock),
            },
        };
        match received {
            Ok(envelope) => Ok(with_valid_length(envelope.frame)),
            Err(error) => Err(nb::Error::Other(error.into())),
        }
    }
}

/// Alarm frames to a FIFO of their own, so that a burst of replies cannot push one out; all other standard data frames to the
/// other. The first filter that matches decides.
fn set_filters(controller: &CanConfigurator<'static>) {
    let alarms = StandardFilter {
        filter: FilterType::BitMask {
            filter: DRIVE_ERROR.as_raw(),
            mask: FUNCTION_CODE_MASK.as_raw(),
        },
        action: Action::StoreInFifo1,
    };
    let others = StandardFilter {
        filter: FilterType::Range {
            from: StandardId::ZERO,
            to: StandardId::MAX,
        },
        action: Action::StoreInFifo0,
    };
    let properties = controller.properties();
    properties.set_standard_filter(StandardFilterSlot::_0, alarms);
    properties.set_standard_filter(StandardFilterSlot::_1, others);
}
