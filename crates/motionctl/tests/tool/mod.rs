//! The tool as a user starts it, and files for it.

// Each test program uses a part of this.
#![allow(dead_code)]

pub(crate) mod bus;
pub(crate) mod page;
pub(crate) mod screen;

use std::path::PathBuf;
use std::process::{Command, Output};
use std::sync::atomic::{AtomicU32, Ordering};

/// A file of its own for each test, removed afterwards.
pub(crate) struct Scratch(pub(crate) PathBuf);

impl Scratch {
    pub(crate) fn new(name: &str, bytes: impl AsRef<[u8]>) -> Self {
        // Tests run beside each other, and two may call their files the same.
        static COUNT: AtomicU32 = AtomicU32::new(0);
        let place = COUNT.fetch_add(1, Ordering::Relaxed);
        let file = format!("motionctl-{}-{place}-{name}", std::process::id());
        let path = std::env::temp_dir().join(file);
        std::fs::write(&path, bytes).expect("a temporary file");
        Self(path)
    }

    pub(crate) fn as_str(&self) -> &str {
        self.0.to_str().expect("a path of plain text")
    }
}

impl Drop for Scratch {
    fn drop(&mut self) {
        // Nothing depends on it: the folder is temporary.
        let _ = std::fs::remove_file(&self.0);
    }
}

/// Runs the tool to its end.
pub(crate) fn motionctl(words: &[&str]) -> Output {
    Command::new(env!("CARGO_BIN_EXE_motionctl"))
        .args(words)
        .output()
        .expect("motionctl runs")
}

/// What it wrote, as text.
pub(crate) fn text(bytes: &[u8]) -> &str {
    core::str::from_utf8(bytes).expect("plain text")
}

/// A folder of its own, which is not there yet, removed afterwards.
pub(crate) struct Folder(pub(crate) PathBuf);

impl Folder {
    pub(crate) fn new(name: &str) -> Self {
        Self(std::env::temp_dir().join(format!("motionctl-{}-{name}", std::process::id())))
    }

    pub(crate) fn as_str(&self) -> &str {
        self.0.to_str().expect("a path of plain text")
    }

    /// A file in it.
    pub(crate) fn file(&self, name: &str) -> String {
        self.0.join(name).to_str().expect("plain text").to_owned()
    }
}

impl Drop for Folder {
    fn drop(&mut self) {
        // Nothing depends on it: the folder is temporary.
        let _ = std::fs::remove_dir_all(&self.0);
    }
}
