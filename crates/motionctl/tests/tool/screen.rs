//! The tool on a terminal of its own, and the screen that a user would see.

use std::num::NonZeroU16;
use std::os::fd::OwnedFd;
use std::process::{Child, Command, ExitStatus, Stdio};
use std::time::{Duration, Instant};

use rustix::event::{PollFd, PollFlags, Timespec, poll};
use rustix::fs::{Mode, OFlags, open};
use rustix::pty::{OpenptFlags, grantpt, openpt, ptsname, unlockpt};
use rustix::termios::{Winsize, tcsetwinsize};

/// Long enough for a machine that is busy with other things.
const PATIENCE: Duration = Duration::from_secs(60);

fn whole(size: u16) -> NonZeroU16 {
    NonZeroU16::new(size).expect("a screen has lines and columns")
}

/// A program on a terminal.
pub(crate) struct OnScreen {
    child: Child,
    device: OwnedFd,
    screen: vt100::Parser,
}

impl OnScreen {
    /// Starts the tool on a terminal of this size.
    pub(crate) fn start(words: &[&str], columns: u16, lines: u16) -> Self {
        let flags = OpenptFlags::RDWR | OpenptFlags::NOCTTY | OpenptFlags::CLOEXEC;
        let device = openpt(flags).expect("a pseudo-terminal");
        grantpt(&device).expect("granted");
        unlockpt(&device).expect("unlocked");
        let size = Winsize {
            ws_row: lines,
            ws_col: columns,
            ws_xpixel: 0,
            ws_ypixel: 0,
        };
        tcsetwinsize(&device, size).expect("its size");
        let name = ptsname(&device, Vec::new()).expect("a name");
        let line = || -> OwnedFd {
            let flags = OFlags::RDWR | OFlags::NOCTTY | OFlags::CLOEXEC;
            open(name.as_c_str(), flags, Mode::empty()).expect("its line")
        };
        // The terminal of the child is this one, whatever terminal the test has.
        let child = Command::new("setsid")
            .args(["--ctty", env!("CARGO_BIN_EXE_motionctl")])
            .args(words)
            .env("TERM", "xterm-256color")
            .stdin(Stdio::from(line()))
            .stdout(Stdio::from(line()))
            .stderr(Stdio::from(line()))
            .spawn()
            .expect("setsid of util-linux is there");
        Self {
            child,
            device,
            screen: vt100::Parser::new(whole(lines), whole(columns), 0),
        }
    }

    /// What the screen shows.
    pub(crate) fn text(&self) -> String {
        self.screen.screen().contents()
    }

    /// Waits until the screen shows something, and returns it.
    pub(crate) fn wait_for(&mut self, what: &str, is_so: impl Fn(&str) -> bool) -> String {
        let start = Instant::now();
        while !is_so(&self.text()) {
            let text = self.text();
            assert!(start.elapsed() < PATIENCE, "no {what} in\n{text}");
            if !self.read() {
                let text = self.text();
                assert!(is_so(&text), "it ended without {what}:\n{text}");
            }
        }
        self.text()
    }

    /// Presses keys.
    pub(crate) fn press(&self, keys: &str) {
        rustix::io::write(&self.device, keys.as_bytes()).expect("the terminal takes keys");
    }

    /// Waits for the end of the program; its output is read meanwhile.
    pub(crate) fn wait(mut self) -> (ExitStatus, String) {
        let start = Instant::now();
        loop {
            let is_open = self.read();
            if let Some(status) = self.child.try_wait().expect("its status") {
                while self.read() {}
                return (status, self.text());
            }
            assert!(start.elapsed() < PATIENCE, "still there:\n{}", self.text());
            if !is_open {
                std::thread::sleep(Duration::from_millis(10));
            }
        }
    }

    /// Reads what the program wrote within a while; false when it will write nothing any more.
    fn read(&mut self) -> bool {
        let timeout = Timespec {
            tv_sec: 0,
            tv_nsec: 50_000_000,
        };
        let mut watched = [PollFd::new(&self.device, PollFlags::IN)];
        match poll(&mut watched, Some(&timeout)) {
            Ok(0) => return true,
            Ok(_) => {}
            Err(error) => panic!("{error}"),
        }
        let mut buffer = [0; 4_096];
        match rustix::io::read(&self.device, &mut buffer) {
            Ok(0) | Err(_) => false,
            Ok(length) => {
                self.screen.process(&buffer[..length]);
                true
            }
        }
    }
}

impl Drop for OnScreen {
    fn drop(&mut self) {
        // It may have ended by itself.
        let _ = self.child.kill();
        let _ = self.child.wait();
    }
}
