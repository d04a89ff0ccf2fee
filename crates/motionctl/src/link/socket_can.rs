//! A CAN network interface of Linux.

use std::io;
use std::os::fd::AsFd;
use std::time::Duration;

use drive_sim::Frame;
use embedded_can::nb::Can;
use embedded_can::{Error as _, Frame as _};
use rustix::event::{PollFd, PollFlags, Timespec, poll};
use rustix::io::Errno;
use socketcan::{CanError, CanFrame, CanSocket, ErrorCause, Socket, SocketOptions};

use super::{Adapter, LinkFault, OpenError};

/// An open network interface.
#[derive(Debug)]
pub(crate) struct SocketCan {
    socket: CanSocket,
    fault: Option<LinkFault>,
}

impl SocketCan {
    /// Opens an interface that is up.
    ///
    /// # Errors
    /// [`OpenError`] says what is missing.
    pub(super) fn open(name: &str) -> Result<Self, OpenError> {
        let failed = |error: io::Error| open_error(name, error);
        // Without CAN in the kernel no interface exists, which would hide the reason: ask for all of them first.
        CanSocket::open_iface(0).map_err(failed)?;
        let socket = CanSocket::open(name).map_err(failed)?;
        socket.set_nonblocking(true).map_err(failed)?;
        // Bus-off and its relatives come as frames of their own.
        socket.set_error_filter_accept_all().map_err(failed)?;
        let mut open = Self {
            socket,
            fault: None,
        };
        // A socket on an interface that is down opens, and says so when it is read first.
        if open.receive() == Err(nb::Error::Other(LinkFault::Down)) {
            let interface = name.to_owned();
            return Err(OpenError::InterfaceDown { interface });
        }
        Ok(open)
    }

    /// Notes a final fault and turns an error into one of the link.
    fn judge(&mut self, error: &socketcan::Error) -> nb::Error<LinkFault> {
        let Some(fault) = fault_of(error) else {
            return nb::Error::WouldBlock;
        };
        if fault.is_final() {
            self.fault = Some(fault);
        }
        nb::Error::Other(fault)
    }
}

impl Adapter for SocketCan {
    fn fault(&self) -> Option<LinkFault> {
        self.fault
    }

    fn wait(&mut self, most: Duration) {
        if self.fault.is_some() {
            return;
        }
        let timeout = Timespec {
            tv_sec: most.as_secs().try_into().unwrap_or(i64::MAX),
            tv_nsec: most.subsec_nanos().into(),
        };
        let socket = self.socket.as_fd();
        // Whatever the outcome, the next `receive` tells more.
        let _ = poll(&mut [PollFd::new(&socket, PollFlags::IN)], Some(&timeout));
    }
}

impl Can for SocketCan {
    type Frame = Frame;
    type Error = LinkFault;

    /// Hands a frame to the queue of the interface. The kernel gives none back, so there is no second outcome.
    fn transmit(&mut self, frame: &Frame) -> nb::Result<Option<Frame>, LinkFault> {
        if let Some(fault) = self.fault {
            return Err(nb::Error::Other(fault));
        }
        let to_send = CanFrame::new(frame.id(), frame.data())
            .filter(|_| !frame.is_remote_frame())
            .or_else(|| CanFrame::new_remote(frame.id(), frame.dlc()));
        let Some(to_send) = to_send else {
            return Err(nb::Error::Other(LinkFault::Bus(
                embedded_can::ErrorKind::Other,
            )));
        };
        match self.socket.transmit(&to_send) {
            Ok(_) => Ok(None),
            Err(nb::Error::WouldBlock) => Err(nb::Error::WouldBlock),
            Err(nb::Error::Other(error)) => Err(self.judge(&error)),
        }
    }

    fn receive(&mut self) -> nb::Result<Frame, LinkFault> {
        if let Some(fault) = self.fault {
            return Err(nb::Error::Other(fault));
        }
        let frame = match self.socket.receive() {
            Ok(frame) => frame,
            Err(nb::Error::WouldBlock) => return Err(nb::Error::WouldBlock),
            Err(nb::Error::Other(error)) => return Err(self.judge(&error)),
        };
        let received = if frame.is_remote_frame() {
            Frame::new_remote(frame.id(), frame.dlc())
        } else {
            Frame::new(frame.id(), frame.data())
        };
        received.ok_or(nb::Error::Other(LinkFault::Bus(
            embedded_can::ErrorKind::Other,
        )))
    }
}

/// What an error means to the link; `None` for a queue that is full at the moment.
fn fault_of(error: &socketcan::Error) -> Option<LinkFault> {
    match error {
        socketcan::Error::Can(causes) if is_bus_off(causes) => Some(LinkFault::BusOff),
        socketcan::Error::Can(causes) => Some(LinkFault::Bus(causes.kind())),
        socketcan::Error::Io(error) => match Errno::from_io_error(error) {
            Some(Errno::NOBUFS | Errno::INTR) => None,
            Some(Errno::NETDOWN) => Some(LinkFault::Down),
            _ => Some(LinkFault::Vanished),
        },
    }
}

fn is_bus_off(causes: &CanError) -> bool {
    causes
        .causes()
        .any(|cause| matches!(cause, ErrorCause::BusOff))
}

/// What is wrong with an interface that cannot be opened.
fn open_error(name: &str, error: io::Error) -> OpenError {
    let interface = name.to_owned();
    match Errno::from_io_error(&error) {
        Some(Errno::AFNOSUPPORT | Errno::PROTONOSUPPORT) => OpenError::NoCanInKernel { interface },
        Some(Errno::NODEV) => OpenError::NoSuchInterface { interface },
        Some(Errno::NETDOWN) => OpenError::InterfaceDown { interface },
        _ => OpenError::System {
            name: interface,
            source: error,
        },
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn errno(errno: Errno) -> io::Error {
        io::Error::from_raw_os_error(errno.raw_os_error())
    }

    #[test]
    fn each_reason_has_its_own_message() {
        let message = |number| open_error("can0", errno(number)).to_string();
        assert!(message(Errno::AFNOSUPPORT).contains("this kernel has no CAN support"));
        assert!(message(Errno::NODEV).contains("there is no CAN interface can0"));
        assert!(message(Errno::NETDOWN).contains("can0 is down"));
        assert!(message(Errno::PERM).contains("cannot open can0"));
    }

    #[test]
    fn a_full_queue_is_no_fault_and_a_lost_interface_is_final() {
        let fault = |number| fault_of(&socketcan::Error::Io(errno(number)));
        assert_eq!(fault(Errno::NOBUFS), None);
        assert_eq!(fault(Errno::NETDOWN), Some(LinkFault::Down));
        assert_eq!(fault(Errno::NODEV), Some(LinkFault::Vanished));
        assert_eq!(fault(Errno::NXIO), Some(LinkFault::Vanished));
        let bus_off = socketcan::Error::from(ErrorCause::BusOff);
        assert_eq!(fault_of(&bus_off), Some(LinkFault::BusOff));
        let lost = socketcan::Error::from(ErrorCause::LostArbitration(3));
        assert!(fault_of(&lost).is_some_and(|fault| !fault.is_final()));
    }
}
