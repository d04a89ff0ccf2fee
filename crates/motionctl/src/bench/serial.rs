//! The serial line of the drives, behind a terminal or port of its own.

use std::io;

use drive_sim::{Bench, DeviceId, DynDrive, SerialLine};

use crate::host_port::{HostPort, Place};

/// Bytes that wait for a host that does not read; more are lost, as in a port without flow control.
const TO_HOST: usize = 4_096;

/// A line at 38400 baud on which every drive hears every byte.
#[derive(Debug)]
pub(super) struct Serial {
    line: SerialLine,
    port: HostPort,
    to_host: Vec<u8>,
}

impl Serial {
    /// A line with these drives behind a terminal or port.
    ///
    /// # Errors
    /// As [`HostPort::create`].
    pub(super) fn create(place: &Place, drives: &[DeviceId]) -> io::Result<Self> {
        Ok(Self {
            line: SerialLine::new(drives.iter().copied()),
            port: HostPort::create(place, "the serial line")?,
            to_host: Vec::new(),
        })
    }

    pub(super) fn port(&self) -> &HostPort {
        &self.port
    }

    /// When the next byte reaches the drives.
    pub(super) fn next_arrival_ns(&self) -> Option<u64> {
        self.line.next_arrival_ns()
    }

    /// Hands the drives what has reached them.
    pub(super) fn deliver(&mut self, bench: &mut Bench<DynDrive>) {
        let now_ns = bench.now_ns();
        self.line.deliver(bench, now_ns);
    }

    /// Takes from the host and gives to the host.
    pub(super) fn exchange(&mut self, bench: &mut Bench<DynDrive>) -> io::Result<()> {
        let now_ns = bench.now_ns();
        let mut buffer = [0; 256];
        self.line.write(now_ns, self.port.read(&mut buffer)?);
        self.line.collect(bench, now_ns);
        self.to_host.extend(self.line.read(now_ns));
        self.to_host.truncate(TO_HOST);
        let written = self.port.write(&self.to_host)?;
        self.to_host.drain(..written);
        Ok(())
    }

    /// When something happens on the line, or on its way to the host, without the host.
    pub(super) fn next_event_ns(&self, bench: &Bench<DynDrive>) -> Option<u64> {
        self.line.next_event_ns(bench)
    }
}
