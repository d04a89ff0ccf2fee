//! Files that a recording writes.

use std::fs::File;
use std::io::{self, BufWriter};
use std::path::{Path, PathBuf};

/// Opens a file before a run whose results would have no place.
pub(crate) fn create(path: &Path) -> io::Result<BufWriter<File>> {
    File::create(path).map(|file| BufWriter::with_capacity(1 << 16, file))
}

/// The first of these files that is one of the files before it, by whatever name; devices and pipes may be given twice.
pub(super) fn given_twice<'a>(paths: &[&'a Path]) -> Option<&'a Path> {
    let name = |path: &Path| -> PathBuf {
        // A file that is not there yet is known by its folder.
        let folder = path
            .parent()
            .filter(|folder| !folder.as_os_str().is_empty());
        let in_folder = || {
            let folder = folder.unwrap_or(Path::new(".")).canonicalize().ok()?;
            Some(folder.join(path.file_name()?))
        };
        let name = path.canonicalize().ok().or_else(in_folder);
        name.unwrap_or_else(|| path.to_owned())
    };
    let is_device = |path: &Path| path.exists() && !path.is_file();
    let mut before: Vec<PathBuf> = Vec::new();
    for &path in paths {
        let name = name(path);
        if before.contains(&name) && !is_device(path) {
            return Some(path);
        }
        before.push(name);
    }
    None
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_file_is_known_by_whatever_name_and_a_device_may_be_given_twice() {
        let folder = tempfile::tempdir().unwrap();
        let (file, new) = (folder.path().join("a"), folder.path().join("new"));
        std::fs::write(&file, "").unwrap();
        let other = folder.path().join(".").join("a");
        let new_again = folder.path().join(".").join("new");
        assert_eq!(given_twice(&[&file, &new, &other]), Some(&*other));
        assert_eq!(given_twice(&[&new, &file, &new_again]), Some(&*new_again));
        assert_eq!(given_twice(&[&file, &new]), None);
        let full = Path::new("/dev/full");
        assert_eq!(given_twice(&[full, full]), None);
    }
}
