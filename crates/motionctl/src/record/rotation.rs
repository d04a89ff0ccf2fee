//! Files of a limited size, of which the newest are kept, on a disk on which room is left.

use std::collections::VecDeque;
use std::fs::{self, File};
use std::io::{self, BufWriter, Write};
use std::path::{Path, PathBuf};
use std::time::{Duration, Instant};

use crate::output::tell;

/// How often what waits is written, and the room on the disk is looked at.
const REST: Duration = Duration::from_millis(500);

/// Where files go and how many.
#[derive(Debug, Clone)]
pub(super) struct Rules {
    pub(super) folder: PathBuf,
    /// In front of the number.
    pub(super) stem: String,
    pub(super) file_bytes: u64,
    pub(super) keep: u64,
    pub(super) least_free_bytes: u64,
}

/// Tells the free bytes of the disk of a folder.
pub(super) type FreeBytes = fn(&Path) -> io::Result<u64>;

/// What was written.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub(super) struct Written {
    pub(super) lines: u64,
    pub(super) files: u64,
    pub(super) removed_files: u64,
    /// In files that were removed because there were too many.
    pub(super) removed_lines: u64,
}

/// Files one after the other.
pub(super) struct Rotation {
    rules: Rules,
    free_bytes: FreeBytes,
    file: BufWriter<File>,
    bytes: u64,
    /// Path and lines of each file that is there, the oldest first.
    files: VecDeque<(PathBuf, u64)>,
    written: Written,
    /// Lines since the last flush.
    waiting: u64,
    rested_at: Instant,
    is_short: bool,
}

impl Rotation {
    /// Opens the first file.
    ///
    /// # Errors
    /// With the path that cannot be made, or when the disk has no room.
    pub(super) fn begin(rules: Rules, free_bytes: FreeBytes) -> Result<Self, (PathBuf, io::Error)> {
        let folder = rules.folder.clone();
        let failed = |error| (folder.clone(), error);
        fs::create_dir_all(&rules.folder).map_err(failed)?;
        let path = path_of(&rules, 1);
        let file = create(&path).map_err(|error| (path.clone(), error))?;
        let mut rotation = Self {
            rules,
            free_bytes,
            file,
            bytes: 0,
            files: VecDeque::from([(path, 0)]),
            written: Written {
                files: 1,
                ..Written::default()
            },
            waiting: 0,
            rested_at: Instant::now(),
            is_short: false,
        };
        rotation.look_at_room().map_err(failed)?;
        Ok(rotation)
    }

    /// Writes a line, into a new file when this one is full.
    ///
    /// # Errors
    /// When it cannot be written.
    pub(super) fn line(&mut self, line: &str) -> io::Result<()> {
        let length = line.len() as u64;
        if self.bytes > 0 && self.bytes + length > self.rules.file_bytes {
            self.next_file()?;
        }
        self.file.write_all(line.as_bytes())?;
        self.bytes += length;
        self.waiting += 1;
        Ok(())
    }

    /// Writes what waits and looks at the room on the disk, when it is time for that.
    ///
    /// # Errors
    /// When something cannot be written, or too little room is left.
    pub(super) fn rest(&mut self) -> io::Result<()> {
        if self.rested_at.elapsed() < REST {
            return Ok(());
        }
        self.rested_at = Instant::now();
        self.flush()?;
        self.look_at_room()
    }

    /// Writes what waits.
    ///
    /// # Errors
    /// When it cannot be written.
    pub(super) fn flush(&mut self) -> io::Result<()> {
        self.file.flush()?;
        self.written.lines += self.waiting;
        if let Some((_, lines)) = self.files.back_mut() {
            *lines += self.waiting;
        }
        self.waiting = 0;
        Ok(())
    }

    pub(super) fn written(&self) -> Written {
        self.written
    }

    /// The newest file.
    pub(super) fn newest(&self) -> &Path {
        self.files
            .back()
            .map_or(&self.rules.folder, |(path, _)| path)
    }

    fn next_file(&mut self) -> io::Result<()> {
        self.flush()?;
        self.look_at_room()?;
        let path = path_of(&self.rules, self.written.files + 1);
        self.file = create(&path)?;
        self.files.push_back((path, 0));
        self.written.files += 1;
        self.bytes = 0;
        while self.files.len() as u64 > self.rules.keep {
            let Some((oldest, lines)) = self.files.pop_front() else {
                break;
            };
            match fs::remove_file(&oldest) {
                Ok(()) => {
                    self.written.removed_files += 1;
                    self.written.removed_lines += lines;
                }
                // Somebody else took it away.
                Err(error) if error.kind() == io::ErrorKind::NotFound => {}
                Err(error) => tell(format_args!("cannot remove {}: {error}", oldest.display())),
            }
        }
        Ok(())
    }

    /// Says when room becomes short, and ends before the disk is full: others need it too.
    fn look_at_room(&mut self) -> io::Result<()> {
        let free = (self.free_bytes)(&self.rules.folder)?;
        let least = self.rules.least_free_bytes;
        let mb = |bytes: u64| bytes / 1_000_000;
        if free < least {
            return Err(io::Error::new(
                io::ErrorKind::StorageFull,
                format!(
                    "{} MB are left on the disk, and --least-free-mb keeps {} MB free",
                    mb(free),
                    mb(least)
                ),
            ));
        }
        let is_short = free < least.saturating_mul(2);
        if is_short && !self.is_short {
            tell(format_args!(
                "warning: {} MB are left on the disk of {}; the recording ends at {} MB",
                mb(free),
                self.rules.folder.display(),
                mb(least)
            ));
        }
        self.is_short = is_short;
        Ok(())
    }
}

fn path_of(rules: &Rules, number: u64) -> PathBuf {
    rules.folder.join(format!("{}-{number:04}.log", rules.stem))
}

/// A file of another recording is not written over.
fn create(path: &Path) -> io::Result<BufWriter<File>> {
    let file = File::options().write(true).create_new(true).open(path)?;
    Ok(BufWriter::with_capacity(1 << 16, file))
}

/// What the system says of a disk.
pub(super) fn free_bytes(folder: &Path) -> io::Result<u64> {
    fs4::available_space(folder)
}

#[cfg(test)]
mod tests {
    use super::*;

    const PLENTY: FreeBytes = |_| Ok(u64::MAX);

    fn rules(folder: &Path) -> Rules {
        Rules {
            folder: folder.join("new"),
            stem: "can".to_owned(),
            file_bytes: 100,
            keep: 3,
            least_free_bytes: 1_000_000,
        }
    }

    fn files(folder: &Path) -> Vec<(String, usize)> {
        let entries = fs::read_dir(folder.join("new")).unwrap();
        let mut files: Vec<(String, usize)> = entries
            .map(|entry| {
                let entry = entry.unwrap();
                let text = fs::read_to_string(entry.path()).unwrap();
                assert!(text.is_empty() || text.ends_with('\n'), "whole lines");
                let name = entry.file_name().into_string().unwrap();
                (name, text.lines().count())
            })
            .collect();
        files.sort();
        files
    }

    #[test]
    fn the_newest_files_stay_and_every_line_is_accounted_for() {
        let folder = tempfile::tempdir().unwrap();
        let mut rotation = Rotation::begin(rules(folder.path()), PLENTY).unwrap();
        // 30 bytes: three lines a file.
        for number in 0..20 {
            rotation.line(&format!("{number:029}\n")).unwrap();
        }
        rotation.flush().unwrap();
        let expected = [
            ("can-0005.log", 3),
            ("can-0006.log", 3),
            ("can-0007.log", 2),
        ];
        assert_eq!(
            files(folder.path()),
            expected.map(|(name, lines)| (name.to_owned(), lines))
        );
        let written = rotation.written();
        assert_eq!((written.lines, written.files), (20, 7));
        assert_eq!((written.removed_files, written.removed_lines), (4, 12));
    }

    #[test]
    fn a_line_longer_than_a_file_still_has_its_place() {
        let folder = tempfile::tempdir().unwrap();
        let mut rotation = Rotation::begin(rules(folder.path()), PLENTY).unwrap();
        for _ in 0..2 {
            rotation.line(&format!("{}\n", "x".repeat(500))).unwrap();
        }
        rotation.flush().unwrap();
        assert_eq!(files(folder.path()).len(), 2);
    }

    #[test]
    fn it_ends_before_the_disk_is_full() {
        let folder = tempfile::tempdir().unwrap();
        let full: FreeBytes = |_| Ok(999_999);
        let refused = Rotation::begin(rules(folder.path()), full);
        let (_, error) = refused.err().unwrap();
        assert_eq!(error.kind(), io::ErrorKind::StorageFull);
        assert!(error.to_string().contains("0 MB are left"), "{error}");
    }

    #[test]
    fn files_of_another_recording_are_left_alone() {
        let folder = tempfile::tempdir().unwrap();
        let rules = rules(folder.path());
        fs::create_dir_all(&rules.folder).unwrap();
        fs::write(rules.folder.join("can-0001.log"), "precious").unwrap();
        let (path, error) = Rotation::begin(rules, PLENTY).err().unwrap();
        assert_eq!(error.kind(), io::ErrorKind::AlreadyExists);
        assert_eq!(fs::read_to_string(path).unwrap(), "precious");
    }
}
