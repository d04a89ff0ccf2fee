//! The level of a switch, from lines of text: 1 or 0.

use std::fs::File;
use std::io::{self, BufRead, BufReader};
use std::path::Path;
use std::sync::{Arc, Mutex, PoisonError};
use std::time::Instant;

use homing::Reading;

/// What was read last.
#[derive(Debug, Default)]
struct Latest {
    level: Option<(bool, Instant)>,
    bad_line: Option<String>,
}

/// Lines that another program writes, read by a thread of their own. When no more come the level grows old, which ends the search.
#[derive(Debug)]
pub(crate) struct SwitchLines {
    latest: Arc<Mutex<Latest>>,
}

impl SwitchLines {
    /// Reads a file, a pipe or a terminal, or standard input for `-`.
    ///
    /// # Errors
    /// When it cannot be opened.
    pub(crate) fn open(path: &Path) -> io::Result<Self> {
        let source: Box<dyn io::Read + Send> = if path == Path::new("-") {
            Box::new(io::stdin())
        } else {
            Box::new(File::open(path)?)
        };
        let latest = Arc::<Mutex<Latest>>::default();
        let shared = Arc::clone(&latest);
        std::thread::Builder::new().spawn(move || {
            for line in BufReader::new(source).lines() {
                let Ok(line) = line else { return };
                let mut latest = shared.lock().unwrap_or_else(PoisonError::into_inner);
                match line.trim() {
                    "1" => latest.level = Some((true, Instant::now())),
                    "0" => latest.level = Some((false, Instant::now())),
                    "" => {}
                    other => {
                        latest.bad_line = Some(other.chars().take(40).collect());
                        return;
                    }
                }
            }
        })?;
        Ok(Self { latest })
    }

    /// The level, with its age on the clock of the station.
    pub(crate) fn level(&self, now: can_motion::Instant) -> Option<Reading<bool>> {
        let latest = self.latest.lock().unwrap_or_else(PoisonError::into_inner);
        let (value, at) = latest.level?;
        let age_us = u64::try_from(at.elapsed().as_micros()).unwrap_or(u64::MAX);
        Some(Reading {
            value,
            at_us: now.as_us().saturating_sub(age_us),
        })
    }

    /// A line that is no level.
    pub(crate) fn fault(&self) -> Option<String> {
        let latest = self.latest.lock().unwrap_or_else(PoisonError::into_inner);
        latest.bad_line.clone()
    }
}
