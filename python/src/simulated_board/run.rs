//! The thread of the board: cycles in real time, bytes between them.

use std::io::{ErrorKind, Read, Write};
use std::net::{TcpListener, TcpStream};
use std::sync::Mutex;
use std::time::{Duration, Instant};

use board_link::board::{Board, BoardConfig, Link};
use board_link::segment::{Player, SegmentConfig, SegmentQueue};
use trajectory::Position;

use super::machine::{Axes, Kept};
use super::{MOST_AXES, MOST_TRACE, Made, Wishes, lock};

/// Segments of the queue, and one place more.
const QUEUE: usize = 65;
const OUT: usize = 4_096;

/// Starts the board, and starts it anew after a reset, until it is to end.
pub(super) fn run(listener: &TcpListener, made: &Made, wishes: &Mutex<Wishes>) {
    let mut boot = 0;
    let mut kept = Kept {
        targets: vec![0; made.limits.len()],
        fault_log: Vec::new(),
        settings: made.settings.clone(),
    };
    let mut host = None;
    while !lock(wishes).is_closing {
        boot += 1;
        let queue = SegmentQueue::<MOST_AXES, QUEUE>::new();
        let start = Start {
            boot,
            kept,
            host,
            queue,
        };
        (kept, host) = live(listener, made, wishes, start);
    }
}

struct Start {
    boot: u32,
    kept: Kept,
    /// The cable stays in a board that is reset.
    host: Option<TcpStream>,
    queue: SegmentQueue<MOST_AXES, QUEUE>,
}

/// From one start to the next reset; gives what survives it.
fn live(
    listener: &TcpListener,
    made: &Made,
    wishes: &Mutex<Wishes>,
    mut start: Start,
) -> (Kept, Option<TcpStream>) {
    let cycles_per_second = 1_000_000 / made.cycle_us;
    let config = SegmentConfig::with_cycles_per_second(cycles_per_second);
    let axes = Axes::new(made, start.boot, start.kept.clone());
    let Some((admission, player)) = start.queue.split(&made.limits, config) else {
        lock(wishes).is_closing = true;
        return (start.kept, None);
    };
    let config = BoardConfig {
        silence: made.silence_cycles,
        ..BoardConfig::with_cycles_per_second(cycles_per_second)
    };
    let mut running = Running {
        board: Board::new(axes, Some(admission), config),
        link: Link::new(),
        player,
        host: start.host,
        now: 0,
        cycle_us: made.cycle_us,
        stand: start
            .kept
            .targets
            .iter()
            .map(|&at| Position::from_counts(at))
            .collect(),
    };
    let begin = Instant::now();
    let cycle = Duration::from_micros(made.cycle_us.into());
    while running.obey(wishes) {
        running.exchange(listener);
        running.cycle(wishes);
        // Whatever the machine is busy with, no cycle is left out.
        let due = cycle * u32::try_from(running.now).unwrap_or(u32::MAX);
        if let Some(early) = due.checked_sub(begin.elapsed()) {
            std::thread::sleep(early);
        }
    }
    (running.board.application().kept(), running.host)
}

struct Running<'q> {
    board: Board<'q, Axes, MOST_AXES>,
    link: Link<OUT>,
    player: Player<'q, MOST_AXES>,
    host: Option<TcpStream>,
    now: u64,
    cycle_us: u32,
    stand: Vec<Position>,
}

impl Running<'_> {
    /// What the test wants; whether the board goes on.
    fn obey(&mut self, wishes: &Mutex<Wishes>) -> bool {
        let mut wishes = lock(wishes);
        let uptime_ms = self.now * u64::from(self.cycle_us) / 1_000;
        let axes = self.board.application();
        axes.is_stop_open = wishes.is_stop_open;
        axes.is_enable_inactive = wishes.is_enable_inactive;
        if let Some(fault) = wishes.fault.take() {
            axes.fail(fault, uptime_ms as u32);
        }
        if core::mem::take(&mut wishes.is_dropped) {
            self.host = None;
        }
        !(wishes.is_closing || core::mem::take(&mut wishes.is_reset))
    }

    fn cycle(&mut self, wishes: &Mutex<Wishes>) {
        self.now += 1;
        let axes = self.board.application();
        axes.before_cycle(&mut self.player);
        if !self.player.phase().is_active() {
            // A homing has brought them there.
            let targets = axes.targets.iter();
            self.stand = targets.map(|&at| Position::from_counts(at)).collect();
            lock(wishes).positions.clone_from(&axes.targets);
        }
        let mut out = self.stand.clone();
        if self.player.advance(self.now, &self.stand, &mut out) {
            let mut wishes = lock(wishes);
            if wishes.trace.len() < MOST_TRACE * (out.len() + 1) {
                wishes.trace.push(self.now as i64);
                wishes
                    .trace
                    .extend(out.iter().map(|position| position.units()));
            } else {
                wishes.trace_lost += 1;
            }
            wishes.positions = out.iter().map(|position| position.counts()).collect();
            self.board
                .application()
                .targets
                .clone_from(&wishes.positions);
            // The next stream begins at the whole count.
            self.stand = wishes
                .positions
                .iter()
                .map(|&at| Position::from_counts(at))
                .collect();
        }
    }

    /// Bytes of the host. There is one, as a cable has one end; the next one waits until it has gone.
    fn exchange(&mut self, listener: &TcpListener) {
        if self.host.is_none()
            && let Ok((stream, _)) = listener.accept()
            && stream.set_nonblocking(true).is_ok()
            && stream.set_nodelay(true).is_ok()
        {
            self.link = Link::new();
            self.host = Some(stream);
        }
        let mut is_gone = false;
        let mut buffer = [0; 4_096];
        if let Some(host) = &mut self.host {
            match host.read(&mut buffer) {
                Ok(0) => is_gone = true,
                Ok(count) => {
                    let bytes = buffer.get(..count).unwrap_or_default();
                    self.link.on_bytes(&mut self.board, self.now, bytes);
                }
                Err(error) => is_gone = !is_transient(error.kind()),
            }
        }
        self.link.poll(&mut self.board, self.now);
        if let Some(host) = &mut self.host {
            match host.write(self.link.output()) {
                Ok(count) => self.link.consume(count),
                Err(error) => is_gone |= !is_transient(error.kind()),
            }
        } else {
            // What is for nobody is gone, as in a cable that was pulled.
            let count = self.link.output().len();
            self.link.consume(count);
        }
        if is_gone {
            self.host = None;
        }
    }
}

fn is_transient(kind: ErrorKind) -> bool {
    matches!(kind, ErrorKind::WouldBlock | ErrorKind::Interrupted)
}
