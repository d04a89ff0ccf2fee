//! A serial line from a host to the drives of a bench: 38400 baud, 8N1 (DYN2 manual A1.8, section 7.1).
//!
//! Specification: every byte takes its time on the wire, and the next one waits for it. Drives in a chain pass on what they hear, each
//! after a while (section 7.8); every drive hears every byte, and what two drives send at once reaches the host mixed up. Time
//! is that of the bench.

use std::collections::VecDeque;

use crate::bench::{Bench, DeviceId};
use crate::device::Device;
use crate::fault::FaultModel;

/// Time of a byte with its start and stop bit.
pub const BYTE_NS: u64 = 10_000_000_000_u64.div_ceil(38_400);

/// A device with a serial port.
pub trait SerialDevice {
    /// A byte that has come in at `now_ns`.
    fn on_serial_byte(&mut self, now_ns: u64, byte: u8);

    /// When the next byte that goes out is through, if one does.
    fn next_serial_ns(&self) -> Option<u64>;

    /// Takes the next byte that is through at `now_ns`, with the instant at which it was.
    fn pop_serial(&mut self, now_ns: u64) -> Option<(u64, u8)>;
}

/// A line with the drives on it, nearest to the host first.
#[derive(Debug)]
pub struct SerialLine {
    drives: Vec<DeviceId>,
    relay_ns: u64,
    /// Bytes on their way: when each arrives, at which of the drives.
    to_drives: Vec<VecDeque<(u64, u8)>>,
    /// When the host's last byte is through.
    host_free_ns: u64,
    /// Bytes on their way back, in the order in which they arrive.
    to_host: VecDeque<(u64, u8)>,
}

impl SerialLine {
    /// A line on which every drive hears a byte at once.
    pub fn new(drives: impl IntoIterator<Item = DeviceId>) -> Self {
        Self::chain(drives, 0)
    }

    /// A chain in which each drive holds back every byte for `relay_ns`, on the way there and on the way back.
    pub fn chain(drives: impl IntoIterator<Item = DeviceId>, relay_ns: u64) -> Self {
        let drives: Vec<DeviceId> = drives.into_iter().collect();
        Self {
            to_drives: vec![VecDeque::new(); drives.len()],
            drives,
            relay_ns,
            host_free_ns: 0,
            to_host: VecDeque::new(),
        }
    }

    /// The host sends bytes at `now_ns`; they go out one after the other.
    pub fn write(&mut self, now_ns: u64, bytes: &[u8]) {
        for byte in bytes {
            self.host_free_ns = self.host_free_ns.max(now_ns).saturating_add(BYTE_NS);
            let mut arrival_ns = self.host_free_ns;
            for queue in &mut self.to_drives {
                queue.push_back((arrival_ns, *byte));
                arrival_ns = arrival_ns.saturating_add(self.relay_ns);
            }
        }
    }

    /// Takes what has reached the host by `now_ns`.
    pub fn read(&mut self, now_ns: u64) -> Vec<u8> {
        let arrived = self.to_host.partition_point(|(at_ns, _)| *at_ns <= now_ns);
        self.to_host
            .drain(..arrived)
            .map(|(_, byte)| byte)
            .collect()
    }

    /// When the next byte arrives somewhere, or leaves a drive.
    pub fn next_event_ns<D: Device + SerialDevice, F: FaultModel>(
        &self,
        bench: &Bench<D, F>,
    ) -> Option<u64> {
        let leaving = self.drives.iter().map(|id| bench.device(*id));
        let leaving = leaving.filter_map(SerialDevice::next_serial_ns);
        let returning = self.to_host.front().map(|(at_ns, _)| *at_ns);
        self.next_arrival_ns()
            .into_iter()
            .chain(leaving)
            .chain(returning)
            .min()
    }

    /// Lets time pass on the bench and on the line until `t_ns`. An instant in the past changes nothing.
    pub fn advance_to<D: Device + SerialDevice, F: FaultModel>(
        &mut self,
        bench: &mut Bench<D, F>,
        t_ns: u64,
    ) {
        while let Some(at_ns) = self.next_arrival_ns().filter(|at_ns| *at_ns <= t_ns) {
            bench.advance_to(at_ns);
            self.deliver(bench, at_ns);
        }
        bench.advance_to(t_ns);
        self.collect(bench, t_ns);
    }

    /// Hands every byte that has arrived by `now_ns` to its drive, without letting time pass: for a bench that is moved by
    /// somebody else.
    pub fn deliver<D: Device + SerialDevice, F: FaultModel>(
        &mut self,
        bench: &mut Bench<D, F>,
        now_ns: u64,
    ) {
        for (queue, id) in self.to_drives.iter_mut().zip(&self.drives) {
            let arrived = queue.partition_point(|(at_ns, _)| *at_ns <= now_ns);
            for (_, byte) in queue.drain(..arrived) {
                bench.device_mut(*id).on_serial_byte(now_ns, byte);
            }
        }
    }

    /// Takes from every drive what has left it by `now_ns`.
    pub fn collect<D: Device + SerialDevice, F: FaultModel>(
        &mut self,
        bench: &mut Bench<D, F>,
        now_ns: u64,
    ) {
        let mut relays_ns = 0_u64;
        for id in &self.drives {
            while let Some((at_ns, byte)) = bench.device_mut(*id).pop_serial(now_ns) {
                self.to_host
                    .push_back((at_ns.saturating_add(relays_ns), byte));
            }
            relays_ns = relays_ns.saturating_add(self.relay_ns);
        }
        // Stable: bytes of one drive keep their order.
        self.to_host
            .make_contiguous()
            .sort_by_key(|(at_ns, _)| *at_ns);
    }

    /// When the next byte arrives at a drive.
    pub fn next_arrival_ns(&self) -> Option<u64> {
        let first = self.to_drives.iter().filter_map(VecDeque::front);
        first.map(|(at_ns, _)| *at_ns).min()
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::dyn_drive::{DynDrive, DynDriveConfig};
    use can_frame::BitRate;

    const MS: u64 = 1_000_000;
    /// Read_Drive_Status of drive 2.
    const READ_STATUS_OF_2: [u8; 4] = [0x02, 0x89, 0x80, 0x8B];

    fn two_drives(ids: [i32; 2]) -> (Bench<DynDrive>, Vec<DeviceId>) {
        let configs = ids.map(|id| DynDriveConfig {
            power_on_delay_ns: 0,
            ..DynDriveConfig::numbered(id).unwrap()
        });
        Bench::with_drives(BitRate::Kbit1000, configs)
    }

    /// When the host has the reply of drive 2, the second of the line, to a read at 0 ns.
    fn reply_ns(relay_ns: u64) -> u64 {
        let (mut bench, drives) = two_drives([1, 2]);
        let mut line = SerialLine::chain(drives, relay_ns);
        line.write(0, &READ_STATUS_OF_2);
        let mut heard = Vec::new();
        while heard.len() < 4 {
            let now_ns = line.next_event_ns(&bench).expect("a byte on its way");
            line.advance_to(&mut bench, now_ns);
            heard.extend(line.read(now_ns));
        }
        assert_eq!(heard, [0x02, 0x99, 0x80, 0x9B]);
        bench.now_ns()
    }

    #[test]
    fn byte_takes_260_us() {
        assert_eq!(BYTE_NS, 260_417);
    }

    #[test]
    fn request_and_reply_take_their_bytes_the_delay_and_the_relays() {
        let direct_ns = 8 * BYTE_NS + 100_000;
        assert_eq!(reply_ns(0), direct_ns);
        assert_eq!(reply_ns(MS), direct_ns + 2 * MS);
    }

    #[test]
    fn host_that_writes_twice_sends_one_after_the_other() {
        let (mut bench, drives) = two_drives([1, 2]);
        let second = drives[1];
        let mut line = SerialLine::new(drives);
        line.write(0, &READ_STATUS_OF_2[..2]);
        line.write(0, &READ_STATUS_OF_2[2..]);
        line.advance_to(&mut bench, 4 * BYTE_NS - 1);
        assert_eq!(bench.device(second).books().serial_requests, 0);
        line.advance_to(&mut bench, 4 * BYTE_NS);
        assert_eq!(bench.device(second).books().serial_requests, 1);
    }

    #[test]
    fn two_drives_of_one_id_answer_together_and_garble_each_other() {
        let (mut bench, drives) = two_drives([2, 2]);
        let mut line = SerialLine::new(drives);
        line.write(0, &READ_STATUS_OF_2);
        line.advance_to(&mut bench, 10 * MS);
        assert_eq!(
            line.read(10 * MS),
            [0x02, 0x02, 0x99, 0x99, 0x80, 0x80, 0x9B, 0x9B]
        );
    }
}
