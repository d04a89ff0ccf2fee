//! An adapter for tests.

use std::path::PathBuf;
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, AtomicUsize, Ordering};
use std::thread::JoinHandle;
use std::time::Duration;

use super::channel::Channel;
use super::slcan::{Settings, Slcan};
use super::{Link, OpenError};
use crate::lawicel::{Lines, Token};
use crate::system::{Input, Pty, wait_for_input};

/// What stands for a line that is longer than any.
const FLUSHED: [u8; 139] = [b'V'; 139];

/// How adapters are opened by default.
pub(super) const SETTINGS: Settings = Settings {
    baud: 115_200,
    kbit_per_s: 1_000,
    expects_answers: true,
};

/// An adapter that answers each command as it was told, on a pseudo-terminal of its own.
pub(crate) struct FakeAdapter {
    link: PathBuf,
    is_over: Arc<AtomicBool>,
    thread: Option<JoinHandle<()>>,
    /// Commands that were not the first of their packet, where only that one is read.
    dropped: Arc<AtomicUsize>,
}

impl FakeAdapter {
    /// An adapter that answers a line with bytes.
    pub(crate) fn new(name: &str, answer: impl Fn(&[u8]) -> Vec<u8> + Send + 'static) -> Self {
        Self::start(name, false, answer)
    }

    /// One that reads the first command of what comes in at a time, and drops the others.
    pub(crate) fn one_command_a_packet(
        name: &str,
        answer: impl Fn(&[u8]) -> Vec<u8> + Send + 'static,
    ) -> Self {
        Self::start(name, true, answer)
    }

    /// Commands that it dropped.
    pub(crate) fn dropped(&self) -> usize {
        self.dropped.load(Ordering::Relaxed)
    }

    fn start(
        name: &str,
        one_a_packet: bool,
        answer: impl Fn(&[u8]) -> Vec<u8> + Send + 'static,
    ) -> Self {
        let link =
            std::env::temp_dir().join(format!("motionctl-slcan-{}-{name}", std::process::id()));
        let pty = Pty::create(&link).unwrap();
        let is_over = Arc::new(AtomicBool::new(false));
        let over = Arc::clone(&is_over);
        let dropped = Arc::new(AtomicUsize::new(0));
        let drops = Arc::clone(&dropped);
        let thread = std::thread::spawn(move || {
            let mut lines = Lines::default();
            let mut buffer = [0; 256];
            while !over.load(Ordering::Relaxed) {
                wait_for_input(&[Input::Terminal(&pty)], Duration::from_millis(5)).unwrap();
                lines.push(pty.read(&mut buffer).unwrap());
                let mut number = 0;
                while let Some(token) = lines.pop() {
                    let line = match token {
                        Token::Line(line) => line,
                        Token::Overlong => FLUSHED.to_vec(),
                        Token::Bell => continue,
                    };
                    number += 1;
                    if one_a_packet && number > 1 {
                        drops.fetch_add(1, Ordering::Relaxed);
                        continue;
                    }
                    // Byte by byte: an answer may come in any portions.
                    for byte in answer(&line) {
                        assert_eq!(pty.write(&[byte]).unwrap(), 1);
                    }
                }
            }
        });
        Self {
            link,
            is_over,
            thread: Some(thread),
            dropped,
        }
    }

    /// Its port.
    pub(crate) fn port(&self) -> &str {
        self.link.to_str().unwrap()
    }

    /// Opens it as a link.
    pub(crate) fn open(&self) -> Link {
        self.link(Channel::Open).unwrap()
    }

    /// Opens it to listen to it.
    pub(crate) fn listen(&self) -> Result<Link, OpenError> {
        self.link(Channel::ListenOnly)
    }

    fn link(&self, channel: Channel) -> Result<Link, OpenError> {
        let slcan = Slcan::open(self.port(), SETTINGS, channel)?;
        Ok(Link::new(Box::new(slcan), SETTINGS.kbit_per_s))
    }

    /// Takes its terminal away.
    pub(crate) fn vanish(&mut self) {
        self.is_over.store(true, Ordering::Relaxed);
        self.thread
            .take()
            .into_iter()
            .for_each(|thread| thread.join().unwrap());
    }
}

impl Drop for FakeAdapter {
    fn drop(&mut self) {
        self.vanish();
    }
}

/// What every adapter answers while it is set up.
pub(crate) fn set_up_answer(line: &[u8]) -> Vec<u8> {
    match line {
        b"V" => b"V1013\r".to_vec(),
        b"C" => b"\x07".to_vec(),
        line if line.len() > 100 => b"\x07".to_vec(),
        _ => b"\r".to_vec(),
    }
}
