//! The functions of an image by the addresses of their instructions, and the names of its interrupts.

use std::path::Path;

use addr2line::Loader;

use crate::image::Image;
use crate::soc::FLASH;

/// The name of the thread among the exceptions.
pub const THREAD: &str = "thread";
/// Folders of the standard library in the sources that debug information names.
const STANDARD_LIBRARY: [&str; 3] = ["/rustc/", "/rustlib/src/", "/library/core/"];
/// The folder of the standard library's packages.
const LIBRARY: &str = "/library/";
/// What stands before the name of a package from a registry.
const REGISTRY: &str = "/registry/src/";

/// Functions by address, those that the compiler has inlined included.
pub struct Names {
    debug_information: Loader,
}

/// A function.
#[derive(Debug, Clone, PartialEq, Eq, PartialOrd, Ord)]
pub struct Function {
    /// Its name with its path; `?` where the image does not say.
    pub name: String,
    /// The file that it is in, empty where the image does not say.
    pub file: String,
}

impl Names {
    /// Reads the debug information of an image.
    ///
    /// # Errors
    /// When the file has none that can be read.
    pub fn read(path: &Path) -> Result<Self, String> {
        let debug_information =
            Loader::new(path).map_err(|reason| format!("{}: {reason}", path.display()))?;
        Ok(Self { debug_information })
    }

    /// The innermost function at an address that does not belong to the standard library: what that does for a function counts for the
    /// function. Code that is the standard library's alone has the name of its symbol.
    #[must_use]
    pub fn function(&self, address: u32) -> Function {
        let mut outermost = None;
        if let Ok(mut frames) = self.debug_information.find_frames(u64::from(address)) {
            while let Ok(Some(frame)) = frames.next() {
                let name = frame
                    .function
                    .as_ref()
                    .and_then(|name| name.demangle().ok());
                let file = frame
                    .location
                    .and_then(|location| location.file)
                    .unwrap_or_default();
                let function = Function {
                    name: name.map_or_else(|| "?".to_owned(), |name| name.into_owned()),
                    file: short(file).to_owned(),
                };
                if !STANDARD_LIBRARY.iter().any(|folder| file.contains(folder)) {
                    return function;
                }
                outermost = Some(function);
            }
        }
        outermost.unwrap_or_else(|| self.symbol(address))
    }

    fn symbol(&self, address: u32) -> Function {
        let symbol = self.debug_information.find_symbol(u64::from(address));
        Function {
            name: symbol.unwrap_or("?").to_owned(),
            file: String::new(),
        }
    }
}

/// A file without what differs from machine to machine: from the name of its package on, or from that of the workspace's folder.
fn short(file: &str) -> &str {
    if let Some((_, package)) = file.split_once(REGISTRY) {
        return package.split_once('/').map_or(package, |(_, file)| file);
    }
    if let Some(place) = file.find(LIBRARY) {
        return &file[place + 1..];
    }
    let root = Path::new(env!("CARGO_MANIFEST_DIR")).parent();
    let relative = root.and_then(|root| Path::new(file).strip_prefix(root).ok());
    relative.and_then(Path::to_str).unwrap_or(file)
}

/// The name of an exception in the vector table of the image.
#[must_use]
pub fn exception(image: &Image, number: u16) -> String {
    if number == 0 {
        return THREAD.to_owned();
    }
    let vector = FLASH + 4 * u32::from(number);
    let handler = image.word(vector);
    let symbol = handler.and_then(|handler| image.symbol_at(handler));
    symbol.map_or_else(|| format!("exception {number}"), str::to_owned)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_file_is_told_without_the_folders_of_this_machine() {
        let registry = "/home/me/.cargo/registry/src/index-0123/embassy-sync-0.8.0/src/channel.rs";
        assert_eq!(short(registry), "embassy-sync-0.8.0/src/channel.rs");
        let library = "/rustc/0123abc/library/compiler-builtins/src/mem/mod.rs";
        assert_eq!(short(library), "library/compiler-builtins/src/mem/mod.rs");
        let root = Path::new(env!("CARGO_MANIFEST_DIR")).parent().unwrap();
        let file = root.join("src/app.rs");
        assert_eq!(short(file.to_str().unwrap()), "src/app.rs");
    }
}
