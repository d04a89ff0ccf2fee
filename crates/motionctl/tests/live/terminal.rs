//! The device side of a pseudo-terminal, for devices that tests make up.

use std::os::fd::OwnedFd;
use std::path::Path;
use std::time::Duration;

use rustix::event::{PollFd, PollFlags, Timespec, poll};
use rustix::fs::{Mode, OFlags, open};
use rustix::io::Errno;
use rustix::pty::{OpenptFlags, grantpt, openpt, ptsname, unlockpt};
use rustix::termios::{OptionalActions, tcgetattr, tcsetattr};

/// The device side of a pseudo-terminal.
pub(crate) struct Terminal {
    device: OwnedFd,
    /// Keeps the line up while nobody else has it open.
    _line: OwnedFd,
}

impl Terminal {
    /// A terminal in raw mode with a link to the side that others open.
    pub(crate) fn new(link: &Path) -> Self {
        let device = openpt(OpenptFlags::RDWR | OpenptFlags::NOCTTY | OpenptFlags::CLOEXEC)
            .expect("a pseudo-terminal");
        grantpt(&device).expect("granted");
        unlockpt(&device).expect("unlocked");
        let name = ptsname(&device, Vec::new()).expect("a name");
        let name = name.to_str().expect("plain text");
        let line = open(
            name,
            OFlags::RDWR | OFlags::NOCTTY | OFlags::CLOEXEC,
            Mode::empty(),
        )
        .expect("its line");
        let mut settings = tcgetattr(&line).expect("settings");
        settings.make_raw();
        tcsetattr(&line, OptionalActions::Now, &settings).expect("raw");
        rustix::io::ioctl_fionbio(&device, true).expect("without waiting");
        let _ = std::fs::remove_file(link);
        std::os::unix::fs::symlink(name, link).expect("a link");
        Self {
            device,
            _line: line,
        }
    }

    /// What came in within a millisecond.
    pub(crate) fn read(&mut self) -> Vec<u8> {
        let timeout = Timespec {
            tv_sec: 0,
            tv_nsec: 500_000,
        };
        let _ = poll(
            &mut [PollFd::new(&self.device, PollFlags::IN)],
            Some(&timeout),
        );
        let mut buffer = [0; 1_024];
        match rustix::io::read(&self.device, &mut buffer) {
            Ok(length) => buffer[..length].to_vec(),
            Err(Errno::AGAIN | Errno::INTR) => Vec::new(),
            Err(error) => panic!("{error}"),
        }
    }

    /// Writes what there is room for, in portions where that is wanted.
    pub(crate) fn write(&mut self, bytes: &mut Vec<u8>, portions: Option<usize>) {
        let most = portions.unwrap_or(usize::MAX);
        while !bytes.is_empty() {
            match rustix::io::write(&self.device, &bytes[..bytes.len().min(most)]) {
                Ok(length) => drop(bytes.drain(..length)),
                Err(Errno::AGAIN | Errno::INTR) => return,
                Err(error) => panic!("{error}"),
            }
            if portions.is_some() {
                std::thread::sleep(Duration::from_micros(200));
            }
        }
    }
}
