//! Sizes of the statics of an image.

use std::fs;
use std::path::Path;

use object::{Object, ObjectSymbol};

use crate::error::Error;

/// Number behind `prefix` in a symbol's name and size of the symbol in bytes, in ascending order of the number.
///
/// # Errors
/// When the file cannot be read, is not an object file, or has no such symbol.
pub(crate) fn sizes_of_symbols(path: &Path, prefix: &str) -> Result<Vec<(u32, u64)>, Error> {
    let wrong = |reason: String| Error::Image {
        path: path.into(),
        reason,
    };
    let bytes = fs::read(path).map_err(|reason| wrong(reason.to_string()))?;
    let file = object::File::parse(&*bytes).map_err(|reason| wrong(reason.to_string()))?;
    let named = file
        .symbols()
        .filter_map(|symbol| Some((symbol.name().ok()?.to_owned(), symbol.size())));
    let sizes = numbered(named, prefix);
    if sizes.is_empty() {
        return Err(wrong(format!("there is no symbol {prefix}<number>")));
    }
    Ok(sizes)
}

fn numbered(symbols: impl Iterator<Item = (String, u64)>, prefix: &str) -> Vec<(u32, u64)> {
    let mut sizes: Vec<_> = symbols
        .filter_map(|(name, size)| Some((name.strip_prefix(prefix)?.parse().ok()?, size)))
        .collect();
    sizes.sort_unstable();
    sizes
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn symbols_are_sorted_by_their_number_and_others_left_out() {
        let symbols = [("OF_14", 300), ("OF_2", 100), ("main", 7), ("OF_X", 9)];
        let symbols = symbols.map(|(name, size)| (name.to_owned(), size));
        assert_eq!(numbered(symbols.into_iter(), "OF_"), [(2, 100), (14, 300)]);
    }

    #[test]
    fn a_file_that_is_no_image_is_refused_with_its_path() {
        let path = Path::new(env!("CARGO_MANIFEST_DIR")).join("Cargo.toml");
        let error = sizes_of_symbols(&path, "OF_").unwrap_err().to_string();
        assert!(error.starts_with(&path.display().to_string()), "{error}");
    }
}
