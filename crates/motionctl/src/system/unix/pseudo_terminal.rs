//! A pseudo-terminal that other programs open like a serial port.

use core::fmt;
use std::fs::{self, File};
use std::io;
use std::os::fd::{AsFd, BorrowedFd, OwnedFd};
use std::os::unix::fs::symlink;
use std::path::{Path, PathBuf};

use rustix::fs::{Mode, OFlags, open};
use rustix::io::Errno;
use rustix::pty::{OpenptFlags, grantpt, openpt, ptsname, unlockpt};
use rustix::termios::{OptionalActions, tcgetattr, tcsetattr};

/// The device side of a pseudo-terminal, with a link under a name of the user's choice to the side that others open.
///
/// The link is removed when the value goes away.
#[derive(Debug)]
pub(crate) struct Pty {
    device: OwnedFd,
    /// Keeps the line up while nobody else has it open.
    _line: OwnedFd,
    link: PathBuf,
    line_path: PathBuf,
}

impl Pty {
    /// Makes a pseudo-terminal in raw mode and links it to `link`.
    ///
    /// # Errors
    /// When `link` exists and is not the forgotten link of an earlier run, or when the system has no pseudo-terminal.
    pub(crate) fn create(link: &Path) -> io::Result<Self> {
        let device = openpt(OpenptFlags::RDWR | OpenptFlags::NOCTTY | OpenptFlags::CLOEXEC)?;
        grantpt(&device)?;
        unlockpt(&device)?;
        let name = ptsname(&device, Vec::new())?;
        let line = open(
            &name,
            OFlags::RDWR | OFlags::NOCTTY | OFlags::CLOEXEC,
            Mode::empty(),
        )?;
        let mut settings = tcgetattr(&line)?;
        settings.make_raw();
        tcsetattr(&line, OptionalActions::Now, &settings)?;
        rustix::io::ioctl_fionbio(&device, true)?;
        let line_path = PathBuf::from(name.to_string_lossy().into_owned());
        remove_forgotten(link)?;
        symlink(&line_path, link)?;
        Ok(Self {
            device,
            _line: line,
            link: link.to_owned(),
            line_path,
        })
    }

    /// Reads what others have written; an empty slice when there is nothing.
    pub(crate) fn read<'a>(&self, buffer: &'a mut [u8]) -> io::Result<&'a [u8]> {
        match rustix::io::read(&self.device, &mut *buffer) {
            Ok(length) => Ok(&buffer[..length]),
            Err(Errno::AGAIN | Errno::INTR) => Ok(&[]),
            Err(error) => Err(error.into()),
        }
    }

    /// Writes as much as there is room for and returns how much that was.
    pub(crate) fn write(&self, bytes: &[u8]) -> io::Result<usize> {
        match rustix::io::write(&self.device, bytes) {
            Ok(length) => Ok(length),
            Err(Errno::AGAIN | Errno::INTR) => Ok(0),
            Err(error) => Err(error.into()),
        }
    }
}

impl AsFd for Pty {
    fn as_fd(&self) -> BorrowedFd<'_> {
        self.device.as_fd()
    }
}

impl fmt::Display for Pty {
    /// The link and what is behind it.
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{} ({})", self.link.display(), self.line_path.display())
    }
}

impl Drop for Pty {
    fn drop(&mut self) {
        // A link that somebody else has put there meanwhile is not ours.
        if fs::read_link(&self.link).is_ok_and(|target| target == self.line_path) {
            // Nothing can be done about a link that stays: the next run takes it for forgotten.
            let _ = fs::remove_file(&self.link);
        }
    }
}

/// Removes a link to a terminal that is gone, as a run that was killed leaves it.
fn remove_forgotten(link: &Path) -> io::Result<()> {
    let is_link = fs::symlink_metadata(link).is_ok_and(|data| data.file_type().is_symlink());
    if is_link && File::open(link).is_err_and(|error| error.kind() == io::ErrorKind::NotFound) {
        fs::remove_file(link)?;
    }
    Ok(())
}

#[cfg(test)]
mod tests {
    use std::io::{Read, Write};
    use std::time::Duration;

    use super::*;
    use crate::system::{Input, wait_for_input};

    fn scratch(name: &str) -> PathBuf {
        std::env::temp_dir().join(format!("motionctl-pty-{}-{name}", std::process::id()))
    }

    #[test]
    fn bytes_cross_it_unchanged_both_ways() {
        let link = scratch("bytes");
        let pty = Pty::create(&link).unwrap();
        let mut line = File::options().read(true).write(true).open(&link).unwrap();
        line.write_all(b"V\r\x03\n\x07").unwrap();
        wait_for_input(&[Input::Terminal(&pty)], Duration::from_secs(10)).unwrap();
        let mut buffer = [0; 64];
        assert_eq!(pty.read(&mut buffer).unwrap(), b"V\r\x03\n\x07");
        assert_eq!(pty.read(&mut buffer).unwrap(), b"");
        assert_eq!(pty.write(b"V1013\r\x07").unwrap(), 7);
        let mut heard = [0; 7];
        line.read_exact(&mut heard).unwrap();
        assert_eq!(&heard, b"V1013\r\x07");
    }

    #[test]
    fn the_link_goes_with_it_and_a_forgotten_one_is_replaced() {
        let link = scratch("link");
        symlink("/dev/pts/no-such-terminal", &link).unwrap();
        let pty = Pty::create(&link).unwrap();
        assert_eq!(fs::read_link(&link).unwrap(), pty.line_path);
        drop(pty);
        assert!(fs::symlink_metadata(&link).is_err());
    }

    #[test]
    fn what_exists_is_not_overwritten() {
        let file = scratch("file");
        fs::write(&file, "precious").unwrap();
        let refused = Pty::create(&file).unwrap_err();
        assert_eq!(refused.kind(), io::ErrorKind::AlreadyExists);
        assert_eq!(fs::read_to_string(&file).unwrap(), "precious");
        fs::remove_file(&file).unwrap();
    }
}
