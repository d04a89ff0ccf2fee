//! The serial port over USB, in the place of the UART: cargo feature `link-usb`. Built and linted; no byte has ever gone through it: the emulator has no USB.
//!
//! The device is a serial port of the class CDC-ACM, which every system has a driver for. There is no executor: the thread polls the one future
//! of the device between two sleeps, and whatever the device waits for is told by its interrupt, which ends the sleep. That interrupt
//! is the lowest of all, so cycle and bus interrupt it. What is left are its critical sections, in the thread and in the interrupt: the longest one writes a
//! packet of 64 bytes to the controller.
//!
//! Nothing here waits for the host. It is held back while the thread has no room for what it sends; what it does not take is lost, as on a
//! serial line.

#[cfg(feature = "stm32g474")]
mod device;
#[cfg(feature = "stm32f405")]
mod otg;
pub(crate) mod packets;

use core::future::{pending, poll_fn};
use core::task::Poll;

use embassy_futures::join::join3;
use embassy_stm32::interrupt::Priority;
use embassy_stm32::uid;
use embassy_usb::class::cdc_acm::{CdcAcmClass, Receiver, Sender, State};
use embassy_usb::{Builder, Config};
use heapless::spsc::{Consumer, Producer, Queue};
use static_cell::ConstStaticCell;

use self::packets::{Fate, PACKET_BYTES, Packets, Patience};
use super::CYCLES_PER_SECOND;
use crate::board::CYCLE_PRIORITY;
use crate::cycle_clock;

#[cfg(feature = "stm32g474")]
use device as chosen;
#[cfg(feature = "stm32f405")]
use otg as chosen;

pub(crate) use chosen::Pins;

/// Vendor and product. These two are for tests, by the rules of pid.codes (<https://pid.codes/1209/0001>), and must not leave your workshop: a
/// product has numbers of its own, which pid.codes gives to open-source projects for nothing. `motionctl` looks at neither of them.
const VENDOR: u16 = 0x1209;
const PRODUCT: u16 = 0x0001;
/// What systems show beside the port; its serial number is that of the chip.
const MANUFACTURER: &str = "motion-board";
#[cfg(feature = "stm32f405")]
const NAME: &str = "motion-board STM32F405";
#[cfg(feature = "stm32g474")]
const NAME: &str = "motion-board STM32G474";

/// Priority of the interrupt: the lowest.
const PRIORITY: Priority = Priority::P15;
const _: () = assert!(
    PRIORITY as u8 > CYCLE_PRIORITY as u8,
    "the interrupt of USB could delay a cycle"
);

/// What has come in: as much as the UART has room for.
const RECEIVED_BYTES: usize = 1_024;
/// What waits to go out.
const SENT_BYTES: usize = 256;
/// Room of the driver for a packet of the control endpoint and one of the data.
const RECEIVED_PACKETS_BYTES: usize = 2 * PACKET_BYTES;
/// A host that takes nothing for so long is gone, as one that says nothing is.
const PATIENCE_CYCLES: u64 = CYCLES_PER_SECOND as u64 / 2;

/// One place of a queue stays free.
type Received = Queue<u8, { RECEIVED_BYTES + 1 }>;
type Sent = Queue<u8, { SENT_BYTES + 1 }>;

/// The end of the thread.
pub(crate) struct Port {
    received: Consumer<'static, u8>,
    sent: Producer<'static, u8>,
    patience: Patience,
    device: Option<Device>,
}

/// The end of the device.
pub(crate) struct Device {
    pins: Pins,
    received: Producer<'static, u8>,
    sent: Consumer<'static, u8>,
}

impl Port {
    /// The port on its pins; nothing runs before [`run`]. To be called once: a second call panics.
    pub(crate) fn new(pins: Pins) -> Self {
        static RECEIVED: ConstStaticCell<Received> = ConstStaticCell::new(Queue::new());
        static SENT: ConstStaticCell<Sent> = ConstStaticCell::new(Queue::new());
        let (received, from_device) = RECEIVED.take().split();
        let (to_device, sent) = SENT.take().split();
        Self {
            received: from_device,
            sent: to_device,
            patience: Patience::new(PATIENCE_CYCLES),
            device: Some(Device {
                pins,
                received,
                sent,
            }),
        }
    }

    /// The other end, once.
    pub(crate) fn take_device(&mut self) -> Option<Device> {
        self.device.take()
    }

    /// Takes bytes that have come in, oldest first; returns how many.
    pub(crate) fn take(&mut self, bytes: &mut [u8]) -> usize {
        let mut count = 0;
        for byte in bytes {
            let Some(received) = self.received.dequeue() else {
                break;
            };
            *byte = received;
            count += 1;
        }
        count
    }

    /// Sends the first of these bytes, as far as there is room; returns how many are done with.
    pub(crate) fn send(&mut self, bytes: &[u8]) -> usize {
        let room = self.sent.capacity() - self.sent.len();
        match self.patience.offer(cycle_clock::cycle(), room, bytes.len()) {
            Fate::Lost => bytes.len(),
            Fate::Kept(count) => bytes
                .iter()
                .take(count)
                .take_while(|byte| self.sent.enqueue(**byte).is_ok())
                .count(),
        }
    }

    /// How often bytes began to be lost because no program took them.
    pub(crate) const fn errors(&self) -> u32 {
        self.patience.times()
    }
}

/// The device, for ever; without one nothing happens. To be polled by the thread.
pub(crate) async fn run(device: Option<Device>) {
    let Some(device) = device else {
        return pending().await;
    };
    let mut packets = [0; RECEIVED_PACKETS_BYTES];
    // 75 bytes are used.
    let mut configuration = [0; 96];
    // 5 bytes are used.
    let mut capabilities = [0; 16];
    let mut control = [0; PACKET_BYTES];
    let mut state = State::new();
    let mut config = Config::new(VENDOR, PRODUCT);
    config.manufacturer = Some(MANUFACTURER);
    config.product = Some(NAME);
    config.serial_number = Some(uid::uid_hex());
    let mut builder = Builder::new(
        chosen::driver(device.pins, &mut packets),
        config,
        &mut configuration,
        &mut capabilities,
        &mut [],
        &mut control,
    );
    let class = CdcAcmClass::new(&mut builder, &mut state, PACKET_BYTES as u16);
    let mut usb = builder.build();
    let (sender, receiver) = class.split();
    join3(
        usb.run(),
        receive(receiver, device.received),
        send(sender, device.sent),
    )
    .await;
}

/// Packets of the host, as long as there is room for a whole one; else the controller lets the host wait.
async fn receive<'d>(
    mut receiver: Receiver<'d, chosen::Driver<'d>>,
    mut received: Producer<'static, u8>,
) {
    let mut packet = [0; PACKET_BYTES];
    loop {
        until(|| (received.capacity() - received.len() >= PACKET_BYTES).then_some(())).await;
        match receiver.read_packet(&mut packet).await {
            Ok(count) => packet.iter().take(count).for_each(|byte| {
                // There is room.
                let _ = received.enqueue(*byte);
            }),
            Err(_) => receiver.wait_connection().await,
        }
    }
}

/// Packets for the host.
async fn send<'d>(mut sender: Sender<'d, chosen::Driver<'d>>, mut sent: Consumer<'static, u8>) {
    let mut packets = Packets::new();
    let mut packet = [0; PACKET_BYTES];
    loop {
        let count = until(|| packets.next(sent.len())).await;
        for byte in packet.iter_mut().take(count) {
            *byte = sent.dequeue().unwrap_or_default();
        }
        let bytes = packet.get(..count).unwrap_or_default();
        if sender.write_packet(bytes).await.is_err() {
            sender.wait_connection().await;
            // What was for a host that is gone.
            while sent.dequeue().is_some() {}
            packets = Packets::new();
        }
    }
}

/// Waits until there is something; whoever polls looks again and again.
async fn until<T>(mut look: impl FnMut() -> Option<T>) -> T {
    poll_fn(|_| look().map_or(Poll::Pending, Poll::Ready)).await
}
