//! The ELF file of an image: what lies where.

use std::collections::HashMap;
use std::fmt;
use std::fs;
use std::io;
use std::ops::Range;
use std::path::{Path, PathBuf};

use object::read::elf::{ElfFile32, ProgramHeader};
use object::{Object, ObjectSection, ObjectSymbol};

/// Bytes and where they are in memory when the processor starts.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Piece {
    /// First address.
    pub address: u32,
    /// Contents.
    pub bytes: Vec<u8>,
}

/// An image for the board.
#[derive(Debug, Clone)]
pub struct Image {
    bytes: Vec<u8>,
    load: Vec<Piece>,
    code: Vec<Piece>,
    symbols: HashMap<String, u32>,
}

/// Why there is no image.
#[derive(Debug)]
pub enum ImageError {
    /// The file cannot be read.
    Read {
        /// The file.
        path: PathBuf,
        /// The reason given by the system.
        reason: io::Error,
    },
    /// The file is not a 32-bit ELF file, or is damaged.
    Format {
        /// The reason given by the reader.
        reason: object::Error,
    },
}

impl fmt::Display for ImageError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Read { path, reason } => {
                write!(f, "{}: {reason}; build it with `cargo fw`", path.display())
            }
            Self::Format { reason } => write!(f, "not an image for the board: {reason}"),
        }
    }
}

impl std::error::Error for ImageError {}

impl Image {
    /// Reads an image.
    ///
    /// # Errors
    /// [`ImageError`] when the file cannot be read or is no 32-bit ELF file.
    pub fn read(path: &Path) -> Result<Self, ImageError> {
        let bytes = fs::read(path).map_err(|reason| ImageError::Read {
            path: path.into(),
            reason,
        })?;
        Self::parse(bytes).map_err(|reason| ImageError::Format { reason })
    }

    /// An image that is nothing but pieces of memory, all of which may be executed: for programs of a few instructions.
    #[must_use]
    pub fn of_pieces(pieces: Vec<Piece>) -> Self {
        Self {
            bytes: Vec::new(),
            code: pieces.clone(),
            load: pieces,
            symbols: HashMap::new(),
        }
    }

    fn parse(bytes: Vec<u8>) -> Result<Self, object::Error> {
        let file: ElfFile32 = ElfFile32::parse(&*bytes)?;
        let (endian, mut load) = (file.endian(), Vec::new());
        for header in file.elf_program_headers() {
            if header.p_type(endian) != object::elf::PT_LOAD {
                continue;
            }
            let contents = header.data(endian, &*bytes).unwrap_or_default();
            // The physical address: initial values of variables lie in flash until the start-up code copies them.
            load.push(Piece {
                address: header.p_paddr(endian),
                bytes: contents.to_vec(),
            });
        }
        let code = file
            .sections()
            .filter(|section| matches!(section.name(), Ok(".text" | ".data")))
            .map(|section| {
                Ok(Piece {
                    address: section.address() as u32,
                    bytes: section.data()?.to_vec(),
                })
            })
            .collect::<Result<_, object::Error>>()?;
        let symbols = file
            .symbols()
            .filter_map(|symbol| Some((symbol.name().ok()?.to_owned(), symbol.address() as u32)))
            .collect();
        Ok(Self {
            load,
            code,
            symbols,
            bytes,
        })
    }

    /// The file itself.
    #[must_use]
    pub fn bytes(&self) -> &[u8] {
        &self.bytes
    }

    /// What a programmer writes into flash.
    #[must_use]
    pub fn load(&self) -> &[Piece] {
        &self.load
    }

    /// Address of a symbol.
    #[must_use]
    pub fn symbol(&self, name: &str) -> Option<u32> {
        self.symbols.get(name).copied()
    }

    /// The symbols whose names contain a text, as they are in the image, with their addresses.
    pub fn symbols_with<'a>(&'a self, text: &'a str) -> impl Iterator<Item = (&'a str, u32)> + 'a {
        let all = self.symbols.iter();
        all.filter(move |(name, _)| name.contains(text))
            .map(|(name, &address)| (name.as_str(), address))
    }

    /// The code of a straight run; `None` where the image has none.
    #[must_use]
    pub fn code(&self, address: u32, bytes: u32) -> Option<&[u8]> {
        self.code.iter().find_map(|piece| {
            let start = address.checked_sub(piece.address)? as usize;
            piece.bytes.get(start..start + bytes as usize)
        })
    }

    /// A word of what is loaded; `None` where the image has none.
    #[must_use]
    pub fn word(&self, address: u32) -> Option<u32> {
        self.load.iter().find_map(|piece| {
            let start = address.checked_sub(piece.address)? as usize;
            let bytes = piece.bytes.get(start..start + 4)?;
            Some(u32::from_le_bytes(bytes.try_into().ok()?))
        })
    }

    /// The symbol at an address, the first in the alphabet where there are several.
    #[must_use]
    pub fn symbol_at(&self, address: u32) -> Option<&str> {
        let all = self.symbols.iter().filter(|symbol| *symbol.1 == address);
        all.map(|(name, _)| name.as_str()).min()
    }

    /// Where the stack lies: from its end, the lowest address, to its start.
    #[must_use]
    pub fn stack(&self) -> Option<Range<u32>> {
        Some(self.symbol("_stack_end")?..self.symbol("_stack_start")?)
    }

    /// Addresses of the halfword `code` in what may be executed; one that is no instruction is never reached.
    pub fn halfwords(&self, code: u16) -> impl Iterator<Item = u32> + '_ {
        self.code.iter().flat_map(move |piece| {
            let halfwords = (piece.address..)
                .step_by(2)
                .zip(piece.bytes.chunks_exact(2));
            halfwords.filter_map(move |(address, bytes)| {
                (u16::from_le_bytes([bytes[0], bytes[1]]) == code).then_some(address)
            })
        })
    }
}
