//! Files that fail, stall or lose their reader.

use std::io::Write;
use std::sync::mpsc::{Sender, channel as unlimited};

use super::super::keep::Keep;
use super::super::sample::Sample;
use super::*;

fn cycle(number: u64) -> Arc<Item> {
    Arc::new(Item::Cycle(Sample {
        at_us: number,
        number,
        load: 0.0,
        is_late: false,
        axes: Vec::new(),
        wheels: Vec::new(),
    }))
}

/// Takes one byte an item and writes it when it is asked to.
struct Bytes<W> {
    to: W,
    held: Vec<u8>,
}

impl<W: Write + Send> Keep for Bytes<W> {
    fn keep(&mut self, _item: &Item) -> io::Result<()> {
        self.held.push(b'x');
        Ok(())
    }

    fn flush(&mut self) -> io::Result<()> {
        self.to.write_all(&self.held)?;
        self.held.clear();
        self.to.flush()
    }

    fn finish(&mut self) -> io::Result<()> {
        self.flush()
    }
}

fn queued(to: impl Write + Send + 'static, length: usize) -> Queued {
    let keep = Bytes {
        to,
        held: Vec::new(),
    };
    let keeper = Keeper::new("test".to_owned(), Box::new(keep), "the motion");
    Queued::start("test".to_owned(), keeper, length).unwrap()
}

/// Waits for a word before each write.
struct Stalled {
    word: Receiver<()>,
    written: Sender<usize>,
}

impl Write for Stalled {
    fn write(&mut self, bytes: &[u8]) -> io::Result<usize> {
        self.word.recv().map_err(io::Error::other)?;
        self.written.send(bytes.len()).map_err(io::Error::other)?;
        Ok(bytes.len())
    }

    fn flush(&mut self) -> io::Result<()> {
        Ok(())
    }
}

#[test]
fn a_full_disk_stops_the_recording_and_everything_is_counted() {
    let full = std::fs::File::options()
        .write(true)
        .open("/dev/full")
        .unwrap();
    let mut queue = queued(full, QUEUE);
    for number in 0..5_000 {
        queue.push(&cycle(number));
    }
    let report = queue.finish();
    assert_eq!((report.recorded.cycles, report.lost.cycles), (0, 5_000));
    assert!(
        report.stopped.unwrap().contains("No space left"),
        "names the cause"
    );
    assert!(!report.reader_has_gone);
}

#[test]
fn a_reader_that_has_gone_is_told_from_a_failure() {
    let (reader, writer) = io::pipe().unwrap();
    drop(reader);
    let mut queue = queued(writer, QUEUE);
    queue.push(&cycle(0));
    let report = queue.finish();
    assert!(report.reader_has_gone);
    assert_eq!(report.lost.cycles, 1);
}

#[test]
fn a_stalled_disk_never_delays_whoever_hands_over() {
    let (give, word) = unlimited();
    let (written, writes) = unlimited();
    let mut queue = queued(Stalled { word, written }, 10);
    // Nothing is written before the word, and every push returns all the same.
    for number in 0..20_000 {
        queue.push(&cycle(number));
    }
    assert!(writes.try_recv().is_err());
    for _ in 0..100 {
        give.send(()).unwrap();
    }
    let report = queue.finish();
    assert_eq!(report.recorded.cycles + report.lost.cycles, 20_000);
    assert!(report.lost.cycles >= 18_000, "{report:?}");
    let bytes: usize = writes.try_iter().sum();
    assert_eq!(
        bytes as u64, report.recorded.cycles,
        "what is counted is written"
    );
    assert!(report.stopped.unwrap().contains("more slowly"));
}

#[test]
fn nothing_is_lost_where_nothing_fails() {
    let mut queue = queued(io::sink(), QUEUE);
    for number in 0..20_000 {
        queue.push(&cycle(number));
    }
    let report = queue.finish();
    assert_eq!((report.recorded.cycles, report.lost.cycles), (20_000, 0));
    assert_eq!(report.stopped, None);
}
