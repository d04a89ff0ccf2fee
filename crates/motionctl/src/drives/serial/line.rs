//! A serial port with the client of the protocol on it, one request after the other.

use std::io::ErrorKind;
use std::num::NonZeroU8;
use std::time::{Duration, Instant};

use dyn_can::StoredDriveId;
use dyn_serial::{Address, Answer, Busy, Client, Dialect, Failure, Poll, Reply, Request, Timing};

use crate::drives::DrivesError;
use crate::link::{BytePort, LinkFault, OpenError, PortOptions};

/// The speed of the drives' ports (DYN2 manual A1.8 section 7.1).
const BAUD: u32 = 38_400;
/// What adapters on USB hold bytes back for, and the system adds.
const PC_DELAY_US: u32 = 20_000;
/// The longest wait in one call of the port.
const LONGEST_WAIT: Duration = Duration::from_millis(20);

/// Portions that are read before anything else is done.
const MOST_READS: u32 = 64;

/// How many drives answer to one id.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum AnswersOnLine {
    /// No drive.
    None,
    /// No drive; the line brings back what is sent.
    OnlyEchoes,
    /// One drive.
    One,
    /// More than one, whose bytes may fall on each other.
    SeveralOrDamaged,
}

/// A port with the drives behind it.
pub(crate) struct Line {
    port: BytePort,
    client: Client,
    timing: Timing,
    start: Instant,
}

impl Line {
    /// Opens a port with up to `chain` drives in a chain behind it. Nothing is sent. The speed is that of the drives unless the user
    /// says another, as of a converter with a speed of its own.
    ///
    /// # Errors
    /// [`OpenError`] says what is wrong with the port.
    pub(crate) fn open(
        name: &str,
        options: PortOptions,
        chain: NonZeroU8,
    ) -> Result<Self, OpenError> {
        let port = BytePort::open(name, options.baud_or(BAUD))?;
        let timing = Timing::chain(chain);
        let timing = Timing {
            quiet_timeout_us: timing.quiet_timeout_us + PC_DELAY_US,
            echo_us: timing.echo_us + PC_DELAY_US,
            reply_timeout_us: timing.reply_timeout_us + PC_DELAY_US,
            ..timing
        };
        Ok(Self {
            port,
            client: Client::new(Dialect::MANUAL, timing),
            timing,
            start: Instant::now(),
        })
    }

    /// How often a read is sent from now on.
    pub(super) fn set_attempts(&mut self, attempts: u8) {
        let attempts = NonZeroU8::new(attempts).unwrap_or(NonZeroU8::MIN);
        let timing = Timing {
            attempts,
            ..self.timing
        };
        self.client = Client::new(Dialect::MANUAL, timing);
    }

    /// Whether a drive answers to its id.
    pub(super) fn answers(&mut self, to: Address) -> Result<bool, DrivesError> {
        let asked = self.client.begin(self.now_us(), to, &Request::ReadDriveId);
        match asked.map(|()| self.finish()) {
            Ok(Ok(result)) => Ok(result.is_ok()),
            Ok(Err(fault)) => Err(DrivesError::Link(fault)),
            // Every drive may be asked for its id, one at a time.
            Err(_) => Ok(false),
        }
    }

    /// How many drives answer to an id: what comes after the first answer is listened to as well.
    pub(super) fn count_answers(&mut self, to: Address) -> Result<AnswersOnLine, DrivesError> {
        let (packets, echoes, damage) = self.heard();
        let is_answered = self.answers(to)?;
        if is_answered {
            self.listen(Duration::from_micros(self.timing.reply_timeout_us.into()))
                .map_err(DrivesError::Link)?;
        }
        let (packets, echoes, damage) = {
            let (all, echoed, damaged) = self.heard();
            (all - packets, echoed - echoes, damaged - damage)
        };
        Ok(match (is_answered, packets.saturating_sub(echoes)) {
            (true, 0 | 1) if damage == 0 => AnswersOnLine::One,
            (false, 0) if damage == 0 && echoes > 0 => AnswersOnLine::OnlyEchoes,
            (false, 0) if damage == 0 => AnswersOnLine::None,
            _ => AnswersOnLine::SeveralOrDamaged,
        })
    }

    /// Intact packets, those among them that were sent from here, and damaged packets with stray bytes, since the client was made.
    fn heard(&self) -> (u32, u32, u32) {
        let line = self.client.line();
        (
            line.packets,
            self.client.traffic().echoes,
            line.stray_bytes
                .saturating_add(line.truncated)
                .saturating_add(line.checksum_errors),
        )
    }

    /// Whether anything comes in that was not asked for. What was left from before is thrown away first.
    pub(super) fn hears_anything(&mut self, wait: Duration) -> Result<bool, DrivesError> {
        let vanished = |_| DrivesError::Link(LinkFault::Vanished);
        self.port.clear_input().map_err(vanished)?;
        std::thread::sleep(wait);
        self.port.has_input().map_err(vanished)
    }

    /// Takes in what comes for so long.
    fn listen(&mut self, wait: Duration) -> Result<(), LinkFault> {
        let start = Instant::now();
        while let Some(left) = wait
            .checked_sub(start.elapsed())
            .filter(|left| !left.is_zero())
        {
            self.hear(left).map_err(|_| LinkFault::Vanished)?;
        }
        Ok(())
    }

    /// Asks a drive and waits for its reply.
    pub(super) fn read(
        &mut self,
        drive: StoredDriveId,
        request: &Request,
    ) -> Result<Reply, DrivesError> {
        match self.exchange(drive, request)? {
            Answer::Reply { reply, .. } => Ok(reply),
            Answer::Sent => Err(DrivesError::Incomplete { drive }),
        }
    }

    /// Sends a command and waits until it has left the port. Nothing says whether the drive obeys.
    pub(super) fn command(
        &mut self,
        drive: StoredDriveId,
        request: &Request,
    ) -> Result<(), DrivesError> {
        self.exchange(drive, request)?;
        Ok(())
    }

    fn exchange(&mut self, drive: StoredDriveId, request: &Request) -> Result<Answer, DrivesError> {
        let fault = |reason: String| DrivesError::Fault { drive, reason };
        let id = dyn_serial::DriveId::new(drive.get().into());
        let to = id.map_err(|error| fault(error.to_string()))?;
        self.client
            .begin(self.now_us(), to.into(), request)
            .map_err(|error| match error {
                Busy::Encode(error) => fault(error.to_string()),
                other => fault(other.to_string()),
            })?;
        let echoes_before = self.client.traffic().echoes;
        self.finish()
            .map_err(DrivesError::Link)?
            .map_err(|failure| match failure {
                Failure::NoReply { .. } if self.client.traffic().echoes > echoes_before => {
                    DrivesError::OnlyEchoes { drive }
                }
                Failure::NoReply { .. } => DrivesError::NoAnswer { drive },
                other => fault(other.to_string()),
            })
    }

    /// Serves the port until the request is done.
    fn finish(&mut self) -> Result<Result<Answer, Failure>, LinkFault> {
        loop {
            // Before anything is sent: what has come meanwhile belongs to what was sent before.
            if self.take_in().is_err() {
                self.client.abandon();
                return Err(LinkFault::Vanished);
            }
            let now_us = self.now_us();
            let served = match self.client.poll(now_us) {
                Poll::Done(result) => return Ok(result),
                Poll::Transmit(packet) => self.send(packet.as_bytes()),
                Poll::Wait { until_us } => {
                    self.hear(Duration::from_micros(until_us.saturating_sub(now_us)))
                }
                // Only when there was no request.
                Poll::Idle => return Ok(Err(Failure::NoReply { attempts: 0 })),
            };
            if served.is_err() {
                self.client.abandon();
                return Err(LinkFault::Vanished);
            }
        }
    }

    fn send(&mut self, bytes: &[u8]) -> std::io::Result<()> {
        self.port.write_all_within(bytes, LONGEST_WAIT)?;
        self.port.flush()
    }

    /// Reads what is there; what a port that never ends brings is no silence, so nothing is sent meanwhile.
    fn take_in(&mut self) -> std::io::Result<()> {
        for _ in 0..MOST_READS {
            if !self.port.has_input()? {
                break;
            }
            self.hear(Duration::ZERO)?;
        }
        Ok(())
    }

    /// Reads what comes within `wait`, or a part of it.
    fn hear(&mut self, wait: Duration) -> std::io::Result<()> {
        let wait = wait.clamp(Duration::from_millis(1), LONGEST_WAIT);
        let mut buffer = [0; 64];
        match self.port.read_within(&mut buffer, wait) {
            Ok(0) => Err(ErrorKind::UnexpectedEof.into()),
            Ok(length) => {
                let now_us = self.now_us();
                for byte in &buffer[..length] {
                    // The client counts what it does not await.
                    let _ = self.client.receive(now_us, *byte);
                }
                Ok(())
            }
            Err(error) => match error.kind() {
                ErrorKind::TimedOut | ErrorKind::WouldBlock | ErrorKind::Interrupted => Ok(()),
                _ => Err(error),
            },
        }
    }

    fn now_us(&self) -> u64 {
        u64::try_from(self.start.elapsed().as_micros()).unwrap_or(u64::MAX)
    }
}

#[cfg(test)]
mod tests {
    use std::sync::mpsc;

    use super::*;
    use crate::system::{Input, Pty, wait_for_input};

    /// Read_MainGain of drive 1, and its replies 20 and 33.
    const READ: [u8; 4] = [0x01, 0x98, 0x80, 0x99];
    const IS_20: [u8; 4] = [0x01, 0x90, 0x94, 0xA5];
    const IS_33: [u8; 4] = [0x01, 0x90, 0xA1, 0xB2];

    #[test]
    fn what_came_before_a_request_is_not_its_reply() {
        let link = std::env::temp_dir().join(format!("motionctl-line-{}", std::process::id()));
        let pty = Pty::create(&link).unwrap();
        let (tell, told) = mpsc::channel::<mpsc::Sender<()>>();
        let drive = std::thread::spawn(move || {
            let (mut buffer, mut heard) = ([0; 64], Vec::new());
            loop {
                wait_for_input(&[Input::Terminal(&pty)], Duration::from_millis(2)).unwrap();
                heard.extend_from_slice(pty.read(&mut buffer).unwrap());
                if heard.ends_with(&READ) {
                    heard.clear();
                    assert_eq!(pty.write(&IS_20).unwrap(), IS_20.len());
                }
                match told.try_recv() {
                    // A reply that nobody awaits, as one that comes late.
                    Ok(written) => {
                        assert_eq!(pty.write(&IS_33).unwrap(), IS_33.len());
                        written.send(()).unwrap();
                    }
                    Err(mpsc::TryRecvError::Empty) => {}
                    Err(mpsc::TryRecvError::Disconnected) => return,
                }
            }
        });
        let options = PortOptions::default();
        let mut line = Line::open(link.to_str().unwrap(), options, NonZeroU8::MIN).unwrap();
        let id = StoredDriveId::new(1).unwrap();
        for is_late in [false, true, false] {
            if is_late {
                let (written, is_written) = mpsc::channel();
                tell.send(written).unwrap();
                is_written.recv().unwrap();
            }
            let reply = line.read(id, &Request::ReadMainGain).unwrap();
            let Reply::MainGain(gain) = reply else {
                panic!("{reply:?}");
            };
            assert_eq!(gain.get(), 20);
        }
        drop(tell);
        drive.join().unwrap();
    }
}
