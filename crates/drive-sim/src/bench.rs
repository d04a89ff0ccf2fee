//! Simulated devices and masters on one bus.
//!
//! Specification: cause before effect. At each instant frames end first, then devices get them, then devices run whose time has come, all in the
//! order of registration; only then does the master act. What is handed over at one instant arbitrates at that instant, whoever
//! handed it over first.

use embedded_can::nb::Can;

use crate::bus::Bus;
use crate::controller::ControllerConfig;
use crate::device::Device;
use crate::fault::{FaultModel, NoFaults};
use crate::node::NodeId;
use crate::port::Port;

/// A device of one bench, in the order of registration.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub struct DeviceId(usize);

#[derive(Debug)]
struct Seat<D> {
    device: D,
    node: NodeId,
    /// A device runs once at an instant.
    not_before_ns: u64,
}

impl<D: Device> Seat<D> {
    /// When the device runs next; `u64::MAX` for never.
    fn due_ns(&self) -> u64 {
        self.device
            .next_event_ns()
            .map_or(u64::MAX, |at_ns| at_ns.max(self.not_before_ns))
    }
}

/// A bus with its devices. Masters are nodes without a device, driven from outside through [`Bench::port`].
///
/// `D` is the concrete type of the devices, so that their state can be read back; use an enum, or `Box<dyn Trait>` with a trait of your
/// own on top of [`Device`], for several kinds.
///
/// # Panics
/// Methods that take a [`DeviceId`] or [`NodeId`] panic if it comes from another, larger bench.
#[derive(Debug)]
pub struct Bench<D, F = NoFaults> {
    bus: Bus<F>,
    seats: Vec<Seat<D>>,
}

impl<D: Device, F: FaultModel> Bench<D, F> {
    /// A bench without devices around `bus`.
    pub fn new(bus: Bus<F>) -> Self {
        Self {
            bus,
            seats: Vec::new(),
        }
    }

    /// Connects a device to a new node of the bus. [`ControllerConfig::device`] is the usual configuration.
    pub fn add_device(&mut self, device: D, config: ControllerConfig) -> DeviceId {
        let node = self.bus.add_node(config);
        self.seats.push(Seat {
            device,
            node,
            not_before_ns: 0,
        });
        DeviceId(self.seats.len() - 1)
    }

    /// Connects a master, or any other node that is driven from outside.
    pub fn add_master(&mut self, config: ControllerConfig) -> NodeId {
        self.bus.add_node(config)
    }

    /// What software on `node` may do; implements `embedded_can::nb::Can`.
    pub fn port(&mut self, node: NodeId) -> Port<'_> {
        self.bus.port(node)
    }

    /// A device, to read its state.
    pub fn device(&self, id: DeviceId) -> &D {
        &self.seats[id.0].device
    }

    /// A device, to change its state.
    pub fn device_mut(&mut self, id: DeviceId) -> &mut D {
        &mut self.seats[id.0].device
    }

    /// All devices, in the order of registration.
    pub fn devices(&self) -> impl ExactSizeIterator<Item = &D> {
        self.seats.iter().map(|seat| &seat.device)
    }

    /// The node of a device.
    pub fn node_of(&self, id: DeviceId) -> NodeId {
        self.seats[id.0].node
    }

    /// The bus: log, load, controllers.
    pub fn bus(&self) -> &Bus<F> {
        &self.bus
    }

    /// The bus: faults, outages, connections, log.
    ///
    /// Let time pass with the bench and not with the bus, or devices will run late.
    pub fn bus_mut(&mut self) -> &mut Bus<F> {
        &mut self.bus
    }

    /// The present instant.
    pub fn now_ns(&self) -> u64 {
        self.bus.now_ns()
    }

    /// The next instant at which something changes by itself, on the bus or in a device.
    pub fn next_event_ns(&self) -> Option<u64> {
        let devices = self
            .seats
            .iter()
            .map(Seat::due_ns)
            .filter(|due_ns| *due_ns < u64::MAX);
        devices
            .map(|due_ns| due_ns.max(self.now_ns()))
            .chain(self.bus.next_event_ns())
            .min()
    }

    /// Lets time pass until `t_ns`, everything due at `t_ns` included. An instant in the past changes nothing.
    pub fn advance_to(&mut self, t_ns: u64) {
        while self.step_to(t_ns) {}
    }

    /// Lets time pass until `node` has a received frame to read, at most until `t_ns`: its receive interrupt. Returns whether it has one.
    pub fn advance_until_received(&mut self, node: NodeId, t_ns: u64) -> bool {
        loop {
            if self.bus.controller(node).rx_pending() > 0 {
                return true;
            }
            if !self.step_to(t_ns) {
                return self.bus.controller(node).rx_pending() > 0;
            }
        }
    }

    /// Lets time pass until the next end of a frame or timer of a device, at most until `limit_ns`.
    ///
    /// Returns false when the limit is reached and nothing is left to do there.
    pub fn step_to(&mut self, limit_ns: u64) -> bool {
        if limit_ns < self.bus.now_ns() {
            return false;
        }
        let due_ns = self
            .seats
            .iter()
            .map(Seat::due_ns)
            .min()
            .unwrap_or(u64::MAX);
        let frame_ended = self.bus.run_to_frame_end(due_ns.min(limit_ns));
        let now_ns = self.bus.now_ns();
        if frame_ended {
            self.hand_out_frames(now_ns);
        }
        let ran = self.run_due(now_ns);
        frame_ended || ran || now_ns < limit_ns
    }

    fn hand_out_frames(&mut self, now_ns: u64) {
        for seat in &mut self.seats {
            while let Some(frame) = self.bus.pop_received(seat.node) {
                seat.device.on_frame(now_ns, &frame);
            }
        }
    }

    fn run_due(&mut self, now_ns: u64) -> bool {
        let mut ran = false;
        for seat in self.seats.iter_mut().filter(|seat| seat.due_ns() <= now_ns) {
            let mut port = self.bus.port(seat.node);
            // The controller counts what it refuses; a device has no other way to learn of it.
            let mut transmit = |frame| {
                let _ = port.transmit(&frame);
            };
            seat.device.run(now_ns, &mut transmit);
            seat.not_before_ns = now_ns + 1;
            ran = true;
        }
        ran
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::frame::Frame;
    use crate::frame::tests::standard;
    use crate::log::LogMode;
    use crate::mailbox::TxOrder;
    use can_frame::BitRate;

    /// Answers each frame after a delay, with the identifier one higher.
    struct Echo {
        delay_ns: u64,
        due: Option<(u64, Frame)>,
        heard_at_ns: Vec<u64>,
    }

    impl Device for Echo {
        fn on_frame(&mut self, now_ns: u64, frame: &Frame) {
            let embedded_can::Id::Standard(id) = embedded_can::Frame::id(frame) else {
                return;
            };
            let reply = standard(id.as_raw() + 1, embedded_can::Frame::data(frame));
            self.heard_at_ns.push(now_ns);
            self.due = Some((now_ns + self.delay_ns, reply));
        }

        fn next_event_ns(&self) -> Option<u64> {
            self.due.map(|(at_ns, _)| at_ns)
        }

        fn run(&mut self, _now_ns: u64, transmit: &mut dyn FnMut(Frame)) {
            self.due
                .take()
                .into_iter()
                .for_each(|(_, reply)| transmit(reply));
        }
    }

    fn bench(delay_ns: u64) -> (Bench<Echo>, NodeId, DeviceId) {
        let mut bus = Bus::new(BitRate::Kbit1000);
        bus.set_log(LogMode::Full);
        let mut bench = Bench::new(bus);
        let master = bench.add_master(ControllerConfig::bxcan(TxOrder::Fifo));
        let echo = bench.add_device(
            Echo {
                delay_ns,
                due: None,
                heard_at_ns: Vec::new(),
            },
            ControllerConfig::device(),
        );
        (bench, master, echo)
    }

    #[test]
    fn reply_starts_after_the_delay_of_the_device() {
        let (mut bench, master, echo) = bench(10_000);
        bench.port(master).transmit(&standard(0x001, &[])).unwrap();
        bench.advance_to(1_000_000);
        // 0x001 without data: 47 bits to the end of EOF.
        assert_eq!(bench.device(echo).heard_at_ns, [47_000]);
        let starts: Vec<u64> = bench
            .bus()
            .log()
            .iter()
            .map(|record| record.start_ns)
            .collect();
        assert_eq!(starts, [0, 57_000]);
        assert_eq!(bench.port(master).receive(), Ok(standard(0x002, &[])));
    }

    #[test]
    fn reply_without_delay_starts_after_the_interframe_space() {
        let (mut bench, master, _) = bench(0);
        bench.port(master).transmit(&standard(0x001, &[])).unwrap();
        assert!(bench.advance_until_received(master, 1_000_000));
        let starts: Vec<u64> = bench
            .bus()
            .log()
            .iter()
            .map(|record| record.start_ns)
            .collect();
        assert_eq!(starts, [0, 50_000]);
        assert_eq!(
            Some(bench.now_ns()),
            bench.bus().log().iter().last().map(|record| record.end_ns)
        );
    }

    #[test]
    fn waiting_for_a_frame_that_does_not_come_ends_at_the_limit() {
        let (mut bench, master, _) = bench(0);
        assert!(!bench.advance_until_received(master, 5_000));
        assert_eq!(bench.now_ns(), 5_000);
        bench.advance_to(4_000);
        assert_eq!(bench.now_ns(), 5_000);
    }

    /// Asks for an instant that has passed, for ever.
    struct Restless(u64);

    impl Device for Restless {
        fn on_frame(&mut self, _now_ns: u64, _frame: &Frame) {}

        fn next_event_ns(&self) -> Option<u64> {
            Some(0)
        }

        fn run(&mut self, _now_ns: u64, _transmit: &mut dyn FnMut(Frame)) {
            self.0 += 1;
        }
    }

    #[test]
    fn restless_device_cannot_stop_time() {
        let mut bench = Bench::new(Bus::new(BitRate::Kbit1000));
        let restless = bench.add_device(Restless(0), ControllerConfig::device());
        bench.advance_to(100);
        assert_eq!((bench.now_ns(), bench.device(restless).0), (100, 101));
    }

    #[test]
    fn frames_of_one_instant_arbitrate_whoever_was_first() {
        let (mut bench, master, _) = bench(3_000);
        bench.port(master).transmit(&standard(0x100, &[])).unwrap();
        bench.advance_until_idle_reply();
        // The device answers with 0x101 at this instant; the master hands over 0x080 at the same one and wins.
        bench.port(master).transmit(&standard(0x080, &[])).unwrap();
        bench.advance_to(1_000_000);
        let frames: Vec<String> = bench
            .bus()
            .log()
            .iter()
            .map(|record| record.frame.to_string())
            .collect();
        assert_eq!(frames[..3], ["100#", "080#", "101#"]);
    }

    impl Bench<Echo> {
        /// Runs to the instant at which the device has handed over its reply.
        fn advance_until_idle_reply(&mut self) {
            while self.seats[0].device.heard_at_ns.is_empty() {
                self.step_to(1_000_000);
            }
            let due_ns = self.next_event_ns().unwrap();
            self.advance_to(due_ns);
        }
    }
}
