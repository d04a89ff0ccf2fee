//! Size of an image: what it takes of flash and of RAM.

use std::fmt;
use std::fs;
use std::path::Path;

use object::{Object, ObjectSection};

use crate::error::Error;

/// The sections that take memory on the board, in the order of the table.
const SECTIONS: [Section; 6] = [
    Section {
        name: ".vector_table",
        flash: true,
        ram: false,
    },
    Section {
        name: ".text",
        flash: true,
        ram: false,
    },
    Section {
        name: ".rodata",
        flash: true,
        ram: false,
    },
    // Its initial values lie in flash and are copied at the start.
    Section {
        name: ".data",
        flash: true,
        ram: true,
    },
    Section {
        name: ".bss",
        flash: false,
        ram: true,
    },
    Section {
        name: ".uninit",
        flash: false,
        ram: true,
    },
];

/// A section and where it takes room.
struct Section {
    name: &'static str,
    flash: bool,
    ram: bool,
}

/// Whether a section takes flash.
pub(crate) fn in_flash(name: &str) -> bool {
    SECTIONS
        .iter()
        .any(|section| section.flash && section.name == name)
}

/// Bytes of each of [`SECTIONS`].
#[derive(Debug, Default, PartialEq, Eq)]
pub(crate) struct Size([u64; SECTIONS.len()]);

impl Size {
    /// Reads the sections of an ELF file.
    ///
    /// # Errors
    /// When the file cannot be read, is not an object file, or has no vector table and so cannot start on the board.
    pub(crate) fn of_image(path: &Path) -> Result<Self, Error> {
        let wrong = |reason: String| Error::Image {
            path: path.into(),
            reason,
        };
        let bytes = fs::read(path).map_err(|reason| wrong(reason.to_string()))?;
        let file = object::File::parse(&*bytes).map_err(|reason| wrong(reason.to_string()))?;
        let size = Self::of_sections(
            file.sections()
                .filter_map(|section| Some((section.name().ok()?.to_owned(), section.size()))),
        );
        if size.bytes(".vector_table") == 0 {
            return Err(wrong(
                "there is no vector table: the linker scripts were not used".into(),
            ));
        }
        Ok(size)
    }

    fn of_sections(sections: impl IntoIterator<Item = (String, u64)>) -> Self {
        let mut size = Self::default();
        for (name, bytes) in sections {
            if let Some(place) = SECTIONS.iter().position(|section| section.name == name) {
                size.0[place] += bytes;
            }
        }
        size
    }

    fn bytes(&self, name: &str) -> u64 {
        self.sum(|section| section.name == name)
    }

    /// Bytes of flash.
    pub(crate) fn flash(&self) -> u64 {
        self.sum(|section| section.flash)
    }

    /// Bytes of static RAM; the stack has what is left.
    pub(crate) fn ram(&self) -> u64 {
        self.sum(|section| section.ram)
    }

    fn sum(&self, counts: impl Fn(&Section) -> bool) -> u64 {
        SECTIONS
            .iter()
            .zip(&self.0)
            .filter(|(section, _)| counts(section))
            .map(|(_, bytes)| bytes)
            .sum()
    }
}

impl fmt::Display for Size {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        writeln!(f, "{:<14} {:>9} {:>9}  bytes", "section", "flash", "RAM")?;
        for (section, bytes) in SECTIONS.iter().zip(&self.0) {
            let column = |counts: bool| {
                if counts {
                    bytes.to_string()
                } else {
                    String::new()
                }
            };
            writeln!(
                f,
                "{:<14} {:>9} {:>9}",
                section.name,
                column(section.flash),
                column(section.ram)
            )?;
        }
        write!(f, "{:<14} {:>9} {:>9}", "total", self.flash(), self.ram())
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn example() -> Size {
        let sections = [
            (".vector_table", 1),
            (".text", 20),
            (".rodata", 300),
            (".data", 4_000),
            (".bss", 50_000),
            (".uninit", 600_000),
            (".debug_info", 7_000_000),
            (".defmt", 80_000_000),
        ];
        Size::of_sections(sections.map(|(name, bytes)| (name.to_owned(), bytes)))
    }

    #[test]
    fn initialised_data_counts_twice_and_debug_information_never() {
        assert_eq!(example().flash(), 4_321);
        assert_eq!(example().ram(), 654_000);
    }

    #[test]
    fn the_table_ends_with_the_totals() {
        let table = example().to_string();
        assert_eq!(table.lines().count(), 8);
        assert_eq!(
            table.lines().last(),
            Some("total               4321    654000")
        );
    }

    #[test]
    fn a_file_that_is_no_image_is_refused_with_its_path() {
        let path = Path::new(env!("CARGO_MANIFEST_DIR")).join("Cargo.toml");
        let error = Size::of_image(&path).unwrap_err().to_string();
        assert!(error.starts_with(&path.display().to_string()), "{error}");
    }
}
