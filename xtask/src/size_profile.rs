//! Where the flash of an image goes, by crate and by symbol.

use std::collections::BTreeMap;
use std::fmt::{self, Write as _};
use std::fs;
use std::path::Path;

use object::{Object, ObjectSection, ObjectSymbol};
use rustc_demangle::demangle;

use crate::error::Error;
use crate::size::in_flash;

/// Symbols on a line of their own; the others share one.
const ROWS: usize = 40;
/// What lies between the symbols.
const UNNAMED: &str = "without a symbol: literals, alignment";

/// Bytes of flash by symbol.
pub(crate) struct SizeProfile {
    symbols: BTreeMap<String, u64>,
}

/// A symbol with its place.
#[derive(Clone, Debug)]
struct Symbol {
    name: String,
    address: u64,
    size: u64,
}

impl SizeProfile {
    /// Reads an ELF file. Each byte of the sections in flash counts once: for its symbol, or as [`UNNAMED`] for its section.
    ///
    /// # Errors
    /// When the file cannot be read or is not an object file.
    pub(crate) fn of_image(path: &Path) -> Result<Self, Error> {
        let wrong = |reason: String| Error::Image {
            path: path.into(),
            reason,
        };
        let bytes = fs::read(path).map_err(|reason| wrong(reason.to_string()))?;
        let file = object::File::parse(&*bytes).map_err(|reason| wrong(reason.to_string()))?;
        let mut profile = Self {
            symbols: BTreeMap::new(),
        };
        for section in file.sections() {
            let Ok(name) = section.name() else { continue };
            if !in_flash(name) {
                continue;
            }
            let of_section = file
                .symbols()
                .filter(|symbol| symbol.section_index() == Some(section.index()))
                .filter_map(|symbol| {
                    Some(Symbol {
                        name: readable(symbol.name().ok()?),
                        // The lowest bit of a function's address says that it is Thumb code.
                        address: symbol.address() & !1,
                        size: symbol.size(),
                    })
                });
            profile.add(name, section.address(), section.size(), of_section);
        }
        Ok(profile)
    }

    fn add(&mut self, section: &str, start: u64, size: u64, symbols: impl Iterator<Item = Symbol>) {
        let mut symbols: Vec<Symbol> = symbols.filter(|symbol| symbol.size > 0).collect();
        symbols.sort_by_key(|symbol| (symbol.address, symbol.size));
        let mut book = |name: String, bytes: u64| {
            if bytes > 0 {
                *self.symbols.entry(name).or_default() += bytes;
            }
        };
        let (mut place, end) = (start, start + size);
        for symbol in symbols {
            // Of several names of one place the first counts.
            let until = (symbol.address + symbol.size).min(end);
            book(
                format!("{section} {UNNAMED}"),
                symbol.address.saturating_sub(place),
            );
            let from = place.max(symbol.address);
            book(symbol.name, until.saturating_sub(from));
            place = place.max(until);
        }
        book(format!("{section} {UNNAMED}"), end.saturating_sub(place));
    }

    fn by_crate(&self) -> BTreeMap<String, u64> {
        let mut crates = BTreeMap::new();
        for (symbol, bytes) in &self.symbols {
            *crates.entry(crate_of(symbol)).or_default() += bytes;
        }
        crates
    }
}

/// The name of a symbol without the hash of the compiler, constants and tables by what they are.
fn readable(name: &str) -> String {
    for (prefix, what) in [
        (".Lanon.", "constants"),
        (".Lswitch.table.", "tables of `match`"),
        (".L_MergedGlobals", "variables"),
    ] {
        if name.starts_with(prefix) {
            return what.into();
        }
    }
    format!("{:#}", demangle(name))
}

/// The crate that a symbol names first. One that is generic belongs to the crate of its source, wherever it was compiled.
fn crate_of(symbol: &str) -> String {
    let path = symbol.trim_start_matches(['<', '&', '(', '[', '*']);
    match path.split_once("::") {
        Some((first, _)) if first.chars().all(|c| c.is_alphanumeric() || c == '_') => first.into(),
        _ if symbol.contains(UNNAMED) => UNNAMED.into(),
        _ => "interrupts, start-up, arithmetic, constants".into(),
    }
}

impl fmt::Display for SizeProfile {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{}", table("crate", &self.by_crate(), usize::MAX))?;
        write!(f, "\n{}", table("symbol", &self.symbols, ROWS))
    }
}

/// The largest first; the lines add up to the last.
fn table(what: &str, parts: &BTreeMap<String, u64>, rows: usize) -> String {
    let mut parts: Vec<(&str, u64)> = parts
        .iter()
        .map(|(name, bytes)| (&**name, *bytes))
        .collect();
    parts.sort_by(|one, other| (other.1, one.0).cmp(&(one.1, other.0)));
    let (shown, rest) = parts.split_at(rows.min(parts.len()));
    let sum = |parts: &[(&str, u64)]| parts.iter().map(|(_, bytes)| bytes).sum::<u64>();
    let mut text = format!("{:>9}  {what}\n", "flash");
    let mut line = |bytes: u64, name: &str| {
        // Writing to a string cannot fail.
        let _ = writeln!(text, "{bytes:>9}  {name}");
    };
    for (name, bytes) in shown {
        line(*bytes, name);
    }
    if !rest.is_empty() {
        line(sum(rest), &format!("{} others", rest.len()));
    }
    line(sum(&parts), "all");
    text
}

#[cfg(test)]
mod tests {
    use super::*;

    fn symbol(name: &str, address: u64, size: u64) -> Symbol {
        Symbol {
            name: name.into(),
            address,
            size,
        }
    }

    fn of_symbols(symbols: &[Symbol]) -> SizeProfile {
        let mut profile = SizeProfile {
            symbols: BTreeMap::new(),
        };
        profile.add(".text", 100, 100, symbols.iter().cloned());
        profile
    }

    #[test]
    fn every_byte_counts_once() {
        let profile = of_symbols(&[
            symbol("a::f", 104, 20),
            // Another name of the same place, and one that reaches further.
            symbol("same", 104, 20),
            symbol("b::g", 110, 20),
            symbol("label", 150, 0),
            // Beyond the end of the section.
            symbol("<a::T as b::U>::h", 190, 30),
        ]);
        let expected = [
            (".text without a symbol: literals, alignment", 64),
            ("<a::T as b::U>::h", 10),
            ("a::f", 20),
            ("b::g", 6),
        ];
        let expected = expected.map(|(name, bytes)| (name.to_owned(), bytes));
        assert_eq!(profile.symbols, BTreeMap::from(expected));
        assert_eq!(profile.symbols.values().sum::<u64>(), 100);
    }

    #[test]
    fn the_lines_of_each_table_add_up_to_the_section() {
        let symbols: Vec<Symbol> = (0..45)
            .map(|n| symbol(&format!("a::f{n}"), 100 + 2 * n, 1 + n % 2))
            .collect();
        let text = of_symbols(&symbols).to_string();
        for table in text.split("\n\n") {
            let bytes = table.lines().skip(1).map(|line| {
                let digits = line.split_whitespace().next().unwrap();
                digits.parse::<u64>().unwrap()
            });
            let mut bytes: Vec<u64> = bytes.collect();
            assert_eq!(bytes.pop(), Some(100), "{table}");
            assert_eq!(bytes.iter().sum::<u64>(), 100, "{table}");
        }
        assert!(text.contains("others"), "{text}");
    }

    #[test]
    fn a_symbol_belongs_to_the_crate_that_it_names_first() {
        assert_eq!(crate_of("<a::T as b::U>::h"), "a");
        assert_eq!(crate_of("a::b::<impl c::D for e::F>::g"), "a");
        assert_eq!(
            crate_of("TIM2"),
            "interrupts, start-up, arithmetic, constants"
        );
    }

    #[test]
    fn a_name_is_told_without_its_hash() {
        assert_eq!(readable("_ZN5dummy3run17h0123456789abcdefE"), "dummy::run");
        assert_eq!(readable(".Lanon.0123.4"), "constants");
    }
}
