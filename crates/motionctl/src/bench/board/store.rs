//! The flash of the board: a file of settings, as `motionctl board settings` reads and writes them.

use std::io;
use std::path::{Path, PathBuf};

use board_settings::{LONGEST, Settings, file};

use crate::backup::{FileFault, create_file};
use crate::output::tell;

/// Where the settings are between two starts.
#[derive(Debug)]
pub(super) struct Store {
    path: Option<PathBuf>,
    /// What the next start finds.
    settings: Option<Settings>,
}

impl Store {
    /// What is in the file, where there is one. Something else than settings is none, and said.
    pub(super) fn open(path: Option<&Path>) -> io::Result<Self> {
        let mut store = Self {
            path: path.map(Path::to_owned),
            settings: None,
        };
        let Some(path) = path else { return Ok(store) };
        let text = match std::fs::read_to_string(path) {
            Ok(text) => text,
            Err(error) if error.kind() == io::ErrorKind::NotFound => return Ok(store),
            Err(error) => return Err(error),
        };
        match file::read(&text) {
            Ok(read) => store.settings = Some(read.settings),
            Err(error) => tell(format_args!(
                "note: {}: {error}: the board has no settings",
                path.display()
            )),
        }
        Ok(store)
    }

    pub(super) const fn settings(&self) -> Option<&Settings> {
        self.settings.as_ref()
    }

    /// As bytes; none without settings.
    pub(super) fn bytes(&self) -> Vec<u8> {
        let mut room = [0; LONGEST];
        let written = self
            .settings
            .as_ref()
            .map(|settings| settings.write(&mut room));
        match written {
            Some(Ok(bytes)) => bytes.to_vec(),
            Some(Err(_)) | None => Vec::new(),
        }
    }

    /// Stores settings: the file has the old or the new ones, whatever happens.
    pub(super) fn save(&mut self, settings: Settings) -> Result<(), FileFault> {
        if let Some(path) = &self.path {
            create_file(path, &file::write(&settings), true)?;
        }
        self.settings = Some(settings);
        Ok(())
    }
}
