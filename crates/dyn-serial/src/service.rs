//! The only place that touches a UART driver.

use embedded_io::{Read, ReadReady, Write};

use crate::client::{Client, Failure, Poll};

/// Bytes that one call of [`service`] reads at most: a port that is always ready must not hold the caller's loop.
pub const MAX_BYTES_A_CALL: usize = 64;

/// Hands the client what has come in and writes what it wants sent; then says how things stand. Call it again when more
/// bytes may have come, and at the time of a [`Poll::Wait`].
///
/// ```
/// use dyn_serial::{Answer, Client, Poll, Reply, service};
/// use embedded_io::{Read, ReadReady, Write};
///
/// /// One turn of the firmware's loop: the reply to whatever was begun, once it is there.
/// fn turn<U: Read + ReadReady + Write>(client: &mut Client, uart: &mut U, now_us: u64) -> Option<Reply> {
///     match service(client, uart, now_us) {
///         Ok(Poll::Done(Ok(Answer::Reply { reply, .. }))) => Some(reply),
///         _ => None,
///     }
/// }
/// ```
///
/// Reads only what is ready. Writing waits for the driver to take at most 7 bytes, 1.8 ms at 38400 baud; a driver with a
/// buffer does not wait. Set the port to 38400 8N1.
///
/// # Errors
/// The first error of the port; the outstanding request is forgotten.
pub fn service<U: Read + ReadReady + Write>(
    client: &mut Client,
    port: &mut U,
    now_us: u64,
) -> Result<Poll, U::Error> {
    let result = exchange(client, port, now_us);
    if result.is_err() {
        client.abandon();
    }
    result
}

fn exchange<U: Read + ReadReady + Write>(
    client: &mut Client,
    port: &mut U,
    now_us: u64,
) -> Result<Poll, U::Error> {
    for _ in 0..MAX_BYTES_A_CALL {
        let mut byte = [0];
        if !port.read_ready()? || port.read(&mut byte)? == 0 {
            break;
        }
        let [byte] = byte;
        // The client counts what it hears; a monitor would look here.
        let _ = client.receive(now_us, byte);
    }
    match client.poll(now_us) {
        Poll::Transmit(packet) => {
            if let Err(taken) = write_all(port, packet.as_bytes())? {
                client.abandon();
                return Ok(Poll::Done(Err(Failure::NotTaken { taken })));
            }
            port.flush()?;
            Ok(client.poll(now_us))
        }
        other => Ok(other),
    }
}

/// Writes everything; the inner error is the number of bytes after which the port took no more.
///
/// `embedded_io::Write::write_all` panics where a driver breaks its contract and takes nothing.
fn write_all<U: Write>(port: &mut U, bytes: &[u8]) -> Result<Result<(), usize>, U::Error> {
    let mut taken = 0;
    while let Some(rest @ [_, ..]) = bytes.get(taken..) {
        match port.write(rest)? {
            0 => return Ok(Err(taken)),
            more => taken = taken.saturating_add(more),
        }
    }
    Ok(Ok(()))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::{Address, Answer, Dialect, DriveId, Request, SpeedRpm, Timing};
    use core::convert::Infallible;
    use std::collections::VecDeque;
    use std::vec::Vec;

    /// A UART that takes at most three bytes at once, and none beyond its room.
    struct Uart {
        incoming: VecDeque<u8>,
        sent: Vec<u8>,
        room: usize,
    }

    impl Default for Uart {
        fn default() -> Self {
            Self {
                incoming: VecDeque::new(),
                sent: Vec::new(),
                room: usize::MAX,
            }
        }
    }

    impl embedded_io::ErrorType for Uart {
        type Error = Infallible;
    }

    impl Read for Uart {
        fn read(&mut self, buffer: &mut [u8]) -> Result<usize, Infallible> {
            let byte = self.incoming.pop_front();
            for (to, from) in buffer.iter_mut().zip(byte) {
                *to = from;
            }
            Ok(usize::from(byte.is_some()))
        }
    }

    impl ReadReady for Uart {
        fn read_ready(&mut self) -> Result<bool, Infallible> {
            Ok(!self.incoming.is_empty())
        }
    }

    impl Write for Uart {
        fn write(&mut self, buffer: &[u8]) -> Result<usize, Infallible> {
            let taken = buffer.len().min(3).min(self.room - self.sent.len());
            self.sent.extend_from_slice(&buffer[..taken]);
            Ok(taken)
        }

        fn flush(&mut self) -> Result<(), Infallible> {
            Ok(())
        }
    }

    fn client() -> Client {
        Client::new(Dialect::MANUAL, Timing::ONE_DRIVE)
    }

    #[test]
    fn a_read_goes_out_and_its_reply_comes_in() {
        let (mut client, mut uart) = (client(), Uart::default());
        let drive = Address::Drive(DriveId::new(1).unwrap());
        client
            .begin(10_000, drive, &Request::ReadDriveStatus)
            .unwrap();
        let waiting = service(&mut client, &mut uart, 10_000).unwrap();
        assert!(matches!(waiting, Poll::Wait { until_us: 60_000 }));
        assert_eq!(uart.sent, [0x01, 0x89, 0x80, 0x8A]);
        uart.incoming.extend([0x01, 0x99, 0xA1, 0xBB]);
        let done = service(&mut client, &mut uart, 15_000).unwrap();
        let Poll::Done(Ok(Answer::Reply { from, .. })) = done else {
            panic!("{done:?}");
        };
        assert_eq!(from.get(), 1);
    }

    #[test]
    fn a_command_is_done_when_it_is_written() {
        let (mut client, mut uart) = (client(), Uart::default());
        let stop = Request::TurnConstSpeed(SpeedRpm::ZERO);
        client.begin(10_000, DriveId::FRESH.into(), &stop).unwrap();
        assert_eq!(
            service(&mut client, &mut uart, 10_000),
            Ok(Poll::Done(Ok(Answer::Sent)))
        );
        assert_eq!(uart.sent, [0x00, 0x8A, 0x80, 0x8A]);
    }

    #[test]
    fn a_port_that_takes_no_more_ends_the_request_and_does_not_panic() {
        let mut client = client();
        let mut uart = Uart {
            room: 3,
            ..Uart::default()
        };
        client
            .begin(10_000, DriveId::FRESH.into(), &Request::ReadDriveId)
            .unwrap();
        assert_eq!(
            service(&mut client, &mut uart, 10_000),
            Ok(Poll::Done(Err(Failure::NotTaken { taken: 3 })))
        );
        assert_eq!(service(&mut client, &mut uart, 10_000), Ok(Poll::Idle));
    }

    #[test]
    fn a_babbling_port_does_not_hold_the_caller() {
        let (mut client, mut uart) = (client(), Uart::default());
        uart.incoming.extend([0xFF; 1_000]);
        assert_eq!(service(&mut client, &mut uart, 0), Ok(Poll::Idle));
        assert_eq!(uart.incoming.len(), 1_000 - MAX_BYTES_A_CALL);
    }
}
