//! An adapter for tests.

use std::path::PathBuf;
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};
use std::thread::JoinHandle;
use std::time::Duration;

use super::slcan::{Channel, Slcan};
use super::{Adapter, Link};
use crate::lawicel::{Lines, Token};
use crate::pty::{self, Pty};

/// An adapter that answers each command as it was told, on a pseudo-terminal of its own.
pub(crate) struct FakeAdapter {
    link: PathBuf,
    is_over: Arc<AtomicBool>,
    thread: Option<JoinHandle<()>>,
}

impl FakeAdapter {
    /// An adapter that answers a line with bytes.
    pub(crate) fn new(name: &str, answer: impl Fn(&[u8]) -> Vec<u8> + Send + 'static) -> Self {
        let link =
            std::env::temp_dir().join(format!("motionctl-slcan-{}-{name}", std::process::id()));
        let pty = Pty::create(&link).unwrap();
        let is_over = Arc::new(AtomicBool::new(false));
        let over = Arc::clone(&is_over);
        let thread = std::thread::spawn(move || {
            let mut lines = Lines::default();
            let mut buffer = [0; 256];
            while !over.load(Ordering::Relaxed) {
                pty::wait([&pty], Duration::from_millis(5)).unwrap();
                lines.push(pty.read(&mut buffer).unwrap());
                while let Some(token) = lines.pop() {
                    let Token::Line(line) = token else { continue };
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
        }
    }

    /// Its port.
    pub(crate) fn port(&self) -> &str {
        self.link.to_str().unwrap()
    }

    /// Opens it as a link.
    pub(crate) fn open(&self) -> Link {
        let slcan = Slcan::open(self.port(), 115_200, 1_000, Channel::Open);
        Link::new(Adapter::Slcan(slcan.unwrap()), 1_000)
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
        _ => b"\r".to_vec(),
    }
}
