//! Socket files: where programs of one user reach each other.

use std::fs;
use std::io::{self, ErrorKind};
use std::os::unix::fs::{FileTypeExt, MetadataExt};
use std::path::{Path, PathBuf};

use rustix::fs::Mode;
use rustix::process::umask;

pub(crate) use std::os::unix::net::UnixListener as SocketFileListener;
pub(crate) use std::os::unix::net::UnixStream as SocketFileStream;

/// A socket file of this program, which is removed at the end.
#[derive(Debug)]
pub(crate) struct SocketFile {
    path: PathBuf,
    inode: u64,
}

impl Drop for SocketFile {
    fn drop(&mut self) {
        // Not the one of a program that came later.
        if fs::symlink_metadata(&self.path).is_ok_and(|file| file.ino() == self.inode) {
            let _ = fs::remove_file(&self.path);
        }
    }
}

impl SocketFile {
    /// Binds a socket file that nobody else may open, from its first moment on. The socket of a program that has ended without removing
    /// it is replaced; anything else stays.
    ///
    /// # Errors
    /// [`ErrorKind::AlreadyExists`] when something else is there, [`ErrorKind::AddrInUse`] when another program listens.
    pub(crate) fn bind(path: &Path) -> io::Result<(SocketFileListener, Self)> {
        make_room(path)?;
        let before = umask(Mode::from_raw_mode(0o177));
        let listener = SocketFileListener::bind(path);
        umask(before);
        let listener = listener?;
        let inode = fs::symlink_metadata(path)?.ino();
        let path = path.to_owned();
        Ok((listener, Self { path, inode }))
    }
}

fn make_room(path: &Path) -> io::Result<()> {
    let Ok(file) = fs::symlink_metadata(path) else {
        return Ok(());
    };
    if !file.file_type().is_socket() {
        return Err(ErrorKind::AlreadyExists.into());
    }
    if SocketFileStream::connect(path).is_ok() {
        return Err(ErrorKind::AddrInUse.into());
    }
    fs::remove_file(path)
}

#[cfg(test)]
mod tests {
    use std::os::unix::fs::PermissionsExt;

    use super::*;

    #[test]
    fn a_socket_file_is_private_and_is_removed_and_nothing_else_is() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("socket");
        let refused = || SocketFile::bind(&path).map(drop).unwrap_err().kind();
        let first = SocketFile::bind(&path).unwrap();
        let mode = fs::metadata(&path).unwrap().permissions().mode();
        assert_eq!(mode & 0o777, 0o600);
        assert_eq!(refused(), ErrorKind::AddrInUse);
        drop(first);
        assert!(!path.exists());
        // One that was left over.
        drop(SocketFileListener::bind(&path).unwrap());
        assert!(path.exists());
        drop(SocketFile::bind(&path).unwrap());
        fs::write(&path, "mine").unwrap();
        assert_eq!(refused(), ErrorKind::AlreadyExists);
        assert_eq!(fs::read_to_string(&path).unwrap(), "mine");
    }
}
