//! Orders at a socket, from any number of programs, one line each.

use std::io::{self, Write};
use std::sync::Arc;
use std::sync::atomic::{AtomicUsize, Ordering};
use std::sync::mpsc::Sender;

use super::words::order;
use super::{Status, Wish, Wishes};
use crate::endpoint::{Endpoint, EndpointError, LONGEST_LINE, Line, LineReader, Listener, Peer};

/// Programs that may give orders at the same time.
const MOST_PEERS: usize = 8;

/// A socket for orders, as long as it is held.
#[derive(Debug)]
pub(crate) struct ControlSocket {
    listener: Listener,
}

impl ControlSocket {
    /// Listens for orders.
    ///
    /// # Errors
    /// [`EndpointError`].
    pub(super) fn open(
        endpoint: &Endpoint,
        allow_remote: bool,
        wishes: &Wishes,
    ) -> Result<Self, EndpointError> {
        let listener = Listener::open(endpoint, allow_remote)?;
        let (sender, status) = (wishes.sender(), wishes.status());
        let failed = |source| EndpointError::Open {
            endpoint: endpoint.to_string(),
            source,
        };
        let door = listener.handle().map_err(failed)?;
        std::thread::Builder::new()
            .spawn(move || {
                let peers = Arc::new(AtomicUsize::new(0));
                while let Ok(peer) = door.next() {
                    let (sender, status) = (sender.clone(), Arc::clone(&status));
                    if peers.load(Ordering::Relaxed) >= MOST_PEERS {
                        peer.dismiss(&format!(
                            "error 0 303 too many programs give orders: expected at most {MOST_PEERS}, got one more"
                        ));
                        continue;
                    }
                    peers.fetch_add(1, Ordering::Relaxed);
                    let count = Arc::clone(&peers);
                    // Whoever cannot be served finds the connection closed.
                    let _ = std::thread::Builder::new().spawn(move || {
                        let _ = serve(peer, &sender, &status);
                        count.fetch_sub(1, Ordering::Relaxed);
                    });
                }
            })
            .map_err(failed)?;
        Ok(Self { listener })
    }

    /// The port that was opened, where there is one.
    pub(crate) fn port(&self) -> Option<u16> {
        self.listener.port()
    }
}

fn serve(peer: Peer, wishes: &Sender<Wish>, status: &Status) -> io::Result<()> {
    let mut answers = peer.again()?;
    let mut lines = LineReader::new(peer);
    let mut number = 0_u64;
    while let Some(line) = lines.next()? {
        number += 1;
        let answer = match &line {
            Line::Text(text) if text.trim().is_empty() => continue,
            Line::Text(text) if text.trim() == "status" => format!("status {number} {status}"),
            Line::Text(text) => match order(text) {
                Ok(order) if wishes.send(Wish::Order(order)).is_ok() => format!("ok {number}"),
                Ok(_) => format!("error {number} 302 the motion has ended"),
                Err(error) => format!("error {number} {} {error}", error.number()),
            },
            line => {
                let (code, text) = broken(line);
                format!("error {number} {code} {text}")
            }
        };
        writeln!(answers, "{answer}")?;
    }
    Ok(())
}

/// Number and text of a line that is none.
pub(crate) fn broken(line: &Line) -> (u16, String) {
    match line {
        Line::Text(_) => (108, "no such word".to_owned()),
        Line::TooLong { actual } => (
            101,
            format!("the line is too long: expected at most {LONGEST_LINE} bytes, got {actual}"),
        ),
        Line::NotText { at } => (
            102,
            format!(
                "the line is no text: expected UTF-8, got another byte at place {}",
                at + 1
            ),
        ),
        Line::Unfinished { actual } => (
            103,
            format!(
                "the line has no end: expected a line feed, got {actual} bytes and the end of the input"
            ),
        ),
    }
}
