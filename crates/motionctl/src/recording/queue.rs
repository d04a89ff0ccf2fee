//! A file of a recording behind a queue: what hands items over never waits.

use std::io;
use std::sync::Arc;
use std::sync::mpsc::{
    Receiver, RecvTimeoutError, SyncSender, TrySendError, channel, sync_channel,
};
use std::time::Duration;

use super::item::Item;
use super::keeper::{Counts, FileReport, Keeper};

/// Items on their way to a file: some ten seconds of a full bus at 1 Mbit/s.
pub(super) const QUEUE: usize = 1 << 17;
/// The longest wait for a file at the end of a motion, when the drives are off.
const FINISH_LIMIT: Duration = Duration::from_secs(10);
/// How often a thread without work looks after its file.
const REST: Duration = Duration::from_millis(100);

/// What a thread of a file is told at the end: items that were not handed over.
#[derive(Debug, Clone, Copy)]
struct Overflow {
    is_one: bool,
    lost: Counts,
}

/// The end of a queue at which items are handed over.
pub(super) struct Queued {
    name: String,
    items: Option<SyncSender<Arc<Item>>>,
    /// Tells the thread what it did not get.
    overflow: SyncSender<Overflow>,
    report: Receiver<FileReport>,
    lost: Counts,
}

impl Queued {
    /// Starts the thread of a file.
    ///
    /// # Errors
    /// When the system has no thread.
    pub(super) fn start(name: String, keeper: Keeper, length: usize) -> io::Result<Self> {
        let (items, to_keep) = sync_channel(length);
        // One message before the items end, one behind them.
        let (overflow, overflows) = sync_channel(2);
        let (to_report, report) = channel();
        std::thread::Builder::new()
            .name("recording".to_owned())
            .spawn(move || {
                // Nobody waits for the report any more when this fails.
                let _ = to_report.send(keep_all(keeper, &to_keep, &overflows));
            })?;
        Ok(Self {
            name,
            items: Some(items),
            overflow,
            report,
            lost: Counts::default(),
        })
    }

    /// Hands an item over. When the queue is full nothing more is handed over: a recording with a gap in it would mislead.
    pub(super) fn push(&mut self, item: &Arc<Item>) {
        let Some(items) = &self.items else {
            self.lost.add(item);
            return;
        };
        match items.try_send(Arc::clone(item)) {
            Ok(()) => {}
            Err(TrySendError::Full(_) | TrySendError::Disconnected(_)) => {
                self.items = None;
                self.lost.add(item);
                // There is room for it, and the thread finds it when the items end.
                let _ = self.overflow.try_send(Overflow {
                    is_one: true,
                    lost: Counts::default(),
                });
            }
        }
    }

    /// Lets the file be closed, and waits for that for a while.
    pub(super) fn finish(mut self) -> FileReport {
        self.items = None;
        let _ = self.overflow.try_send(Overflow {
            is_one: self.lost != Counts::default(),
            lost: self.lost,
        });
        drop(self.overflow);
        self.report.recv_timeout(FINISH_LIMIT).unwrap_or_else(|_| {
            let stopped = format!(
                "not closed within {} s: nobody takes what is written",
                FINISH_LIMIT.as_secs()
            );
            crate::output::tell(format_args!("the recording {}: {stopped}", self.name));
            FileReport {
                path: self.name,
                recorded: Counts::default(),
                lost: self.lost,
                stopped: Some(stopped),
                reader_has_gone: false,
            }
        })
    }
}

/// Keeps items until their end, then learns what is missing, and closes the file.
fn keep_all(
    mut keeper: Keeper,
    items: &Receiver<Arc<Item>>,
    overflows: &Receiver<Overflow>,
) -> FileReport {
    loop {
        match items.recv_timeout(REST) {
            Ok(item) => keeper.take(&item),
            Err(RecvTimeoutError::Timeout) => {}
            Err(RecvTimeoutError::Disconnected) => break,
        }
        keeper.rest();
    }
    let mut is_told = false;
    while let Ok(overflow) = overflows.recv() {
        if overflow.is_one {
            let reason = "it is written more slowly than the bus is read, and the queue is full";
            keeper.stop(io::Error::other(reason), overflow.lost);
            if !is_told {
                keeper.tell_of_stop();
            }
            is_told = true;
        }
    }
    keeper.finish()
}

/// Something that shows a recording while it is made: it may miss items, and nothing is counted.
pub(crate) struct Viewer {
    items: SyncSender<Arc<Item>>,
}

impl Viewer {
    /// A viewer and where it gets its items.
    pub(crate) fn new() -> (Self, Receiver<Arc<Item>>) {
        let (items, shown) = sync_channel(QUEUE);
        (Self { items }, shown)
    }

    pub(super) fn push(&self, item: &Arc<Item>) {
        // One that is too slow or has gone shows less.
        let _ = self.items.try_send(Arc::clone(item));
    }
}

#[cfg(test)]
mod tests;
