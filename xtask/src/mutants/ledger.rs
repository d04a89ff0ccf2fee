//! What is known of each mistake, kept over runs.

use std::collections::hash_map::DefaultHasher;
use std::collections::{BTreeMap, BTreeSet};
use std::fs;
use std::hash::{Hash, Hasher};
use std::io;
use std::path::{Path, PathBuf};

use crate::error::Error;

/// What came of a mistake; each kind is a file, here and in the results of cargo-mutants.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub(super) enum Outcome {
    /// A test failed.
    Caught,
    /// No test failed.
    Missed,
    /// The tests did not end; they do without the mistake.
    Timeout,
    /// It does not compile.
    Unviable,
}

impl Outcome {
    pub(super) const ALL: [Self; 4] = [Self::Caught, Self::Missed, Self::Timeout, Self::Unviable];

    /// The file with the names.
    pub(super) fn file(self) -> &'static str {
        match self {
            Self::Caught => "caught.txt",
            Self::Missed => "missed.txt",
            Self::Timeout => "timeout.txt",
            Self::Unviable => "unviable.txt",
        }
    }
}

/// The folder with what is known, and the sources for which it was found.
const KNOWN: &str = "known";
const SOURCES: &str = "sources.txt";

/// What is known.
pub(super) struct Ledger {
    folder: PathBuf,
    outcomes: BTreeMap<String, Outcome>,
    sources: BTreeMap<String, u64>,
}

impl Ledger {
    /// Reads what is known and drops what was found in sources that have changed.
    ///
    /// # Errors
    /// When a file that is there cannot be read.
    pub(super) fn open(
        folder: PathBuf,
        sources: &BTreeMap<String, Vec<u8>>,
    ) -> Result<Self, Error> {
        let sources: BTreeMap<String, u64> = sources
            .iter()
            .map(|(name, text)| (name.clone(), hash(text)))
            .collect();
        let known = folder.join(KNOWN);
        let before: BTreeMap<String, u64> = lines(&known.join(SOURCES))?
            .iter()
            .filter_map(|line| {
                let (hash, name) = line.split_once(' ')?;
                Some((name.to_owned(), hash.parse().ok()?))
            })
            .collect();
        let mut outcomes = BTreeMap::new();
        for outcome in Outcome::ALL {
            let names = lines(&known.join(outcome.file()))?;
            outcomes.extend(names.into_iter().map(|name| (name, outcome)));
        }
        let is_valid = |name: &String| {
            let source = source_of(name);
            sources
                .get(source)
                .is_none_or(|now| before.get(source) == Some(now))
        };
        outcomes.retain(|name, _| is_valid(name));
        let mut kept = before;
        kept.extend(sources);
        Ok(Self {
            folder,
            outcomes,
            sources: kept,
        })
    }

    /// Whether a mistake was tested.
    pub(super) fn knows(&self, name: &str) -> bool {
        self.outcomes.contains_key(name)
    }

    /// What came of a mistake.
    pub(super) fn outcome(&self, name: &str) -> Option<Outcome> {
        self.outcomes.get(name).copied()
    }

    /// Every mistake that was tested.
    pub(super) fn tested(&self) -> impl Iterator<Item = &str> {
        self.outcomes.keys().map(String::as_str)
    }

    /// Lets survivors be tested again.
    pub(super) fn forget_survivors(&mut self) {
        self.outcomes
            .retain(|_, outcome| *outcome != Outcome::Missed);
    }

    /// Takes in the results of a run and writes everything down.
    ///
    /// # Errors
    /// When a file cannot be read or written.
    pub(super) fn take_in(&mut self, results: &Path) -> Result<(), Error> {
        for outcome in Outcome::ALL {
            for name in lines(&results.join(outcome.file()))? {
                self.outcomes.insert(name, outcome);
            }
        }
        self.write()
    }

    fn write(&self) -> Result<(), Error> {
        let known = self.folder.join(KNOWN);
        fs::create_dir_all(&known).map_err(|reason| failed(&known, &reason))?;
        for outcome in Outcome::ALL {
            let of_this = self.outcomes.iter().filter(|(_, known)| **known == outcome);
            let names: BTreeSet<&str> = of_this.map(|(name, _)| name.as_str()).collect();
            let text: String = names.iter().map(|name| format!("{name}\n")).collect();
            write(&known.join(outcome.file()), &text)?;
        }
        let sources = self.sources.iter();
        let text: String = sources
            .map(|(name, hash)| format!("{hash} {name}\n"))
            .collect();
        write(&known.join(SOURCES), &text)
    }
}

/// The file in which a mistake is made: its name begins with `path:line:column: `.
pub(super) fn source_of(name: &str) -> &str {
    name.split(':').next().unwrap_or(name)
}

/// A hash that tells a changed file; collisions by intent are nobody's interest here.
fn hash(text: &[u8]) -> u64 {
    let mut hasher = DefaultHasher::new();
    text.hash(&mut hasher);
    hasher.finish()
}

/// The lines of a file, none when there is no such file.
fn lines(path: &Path) -> Result<Vec<String>, Error> {
    match fs::read_to_string(path) {
        Ok(text) => Ok(text.lines().map(str::to_owned).collect()),
        Err(error) if error.kind() == io::ErrorKind::NotFound => Ok(Vec::new()),
        Err(error) => Err(failed(path, &error)),
    }
}

pub(super) fn write(path: &Path, text: &str) -> Result<(), Error> {
    fs::write(path, text).map_err(|reason| failed(path, &reason))
}

pub(super) fn failed(path: &Path, reason: &io::Error) -> Error {
    Error::Source {
        path: path.to_path_buf(),
        reason: reason.to_string(),
    }
}

#[cfg(test)]
mod tests {
    use std::env;

    use super::*;

    const A: &str = "src/a.rs:1:1: replace + with -";
    const B: &str = "src/b.rs:2:9: replace f with ()";
    const C: &str = "src/b.rs:3:9: replace < with >";

    /// A folder of its own for each test.
    fn folder(test: &str) -> PathBuf {
        let folder = env::temp_dir().join(format!("xtask-mutants-{}-{test}", std::process::id()));
        let _ = fs::remove_dir_all(&folder);
        fs::create_dir_all(folder.join("results")).unwrap();
        folder
    }

    fn sources(b: &str) -> BTreeMap<String, Vec<u8>> {
        BTreeMap::from([
            ("src/a.rs".into(), b"a".to_vec()),
            ("src/b.rs".into(), b.as_bytes().to_vec()),
        ])
    }

    fn after_one_run(folder: &Path) {
        let results = folder.join("results");
        write(&results.join("caught.txt"), &format!("{A}\n")).unwrap();
        write(&results.join("missed.txt"), &format!("{B}\n{C}\n")).unwrap();
        let mut ledger = Ledger::open(folder.to_path_buf(), &sources("b")).unwrap();
        ledger.take_in(&results).unwrap();
    }

    #[test]
    fn what_was_tested_is_known_in_the_next_run() {
        let folder = folder("next");
        after_one_run(&folder);
        let ledger = Ledger::open(folder.clone(), &sources("b")).unwrap();
        assert_eq!(ledger.outcome(A), Some(Outcome::Caught));
        assert_eq!(ledger.outcome(B), Some(Outcome::Missed));
        assert_eq!(ledger.tested().count(), 3);
        fs::remove_dir_all(folder).unwrap();
    }

    #[test]
    fn a_changed_source_is_tested_anew_and_the_others_are_not() {
        let folder = folder("changed");
        after_one_run(&folder);
        let ledger = Ledger::open(folder.clone(), &sources("changed")).unwrap();
        assert_eq!(ledger.tested().collect::<Vec<_>>(), [A]);
        fs::remove_dir_all(folder).unwrap();
    }

    #[test]
    fn a_survivor_that_is_tested_again_can_be_caught() {
        let folder = folder("again");
        after_one_run(&folder);
        let mut ledger = Ledger::open(folder.clone(), &sources("b")).unwrap();
        ledger.forget_survivors();
        assert!(!ledger.knows(B) && ledger.knows(A));
        let results = folder.join("results");
        write(&results.join("caught.txt"), &format!("{B}\n")).unwrap();
        write(&results.join("missed.txt"), &format!("{C}\n")).unwrap();
        ledger.take_in(&results).unwrap();
        let ledger = Ledger::open(folder.clone(), &sources("b")).unwrap();
        assert_eq!(ledger.outcome(B), Some(Outcome::Caught));
        assert_eq!(ledger.outcome(C), Some(Outcome::Missed));
        fs::remove_dir_all(folder).unwrap();
    }
}
