//! Files that are no text, by their first bytes.

/// First bytes, what begins so, and what to do with it.
const KINDS: [(&[u8], &str); 8] = [
    (
        b"LOGG",
        "a BLF log of Vector; convert it to text, for instance with `python -m can.logconvert in.blf out.asc`",
    ),
    (
        b"MDF     ",
        "an MDF measurement; export its CAN frames as .asc",
    ),
    (
        b"UnFinMF ",
        "an MDF measurement; export its CAN frames as .asc",
    ),
    (&[0x1F, 0x8B], "a gzip file; unpack it first"),
    (b"PK\x03\x04", "a zip file; unpack it first"),
    (
        &[0x0A, 0x0D, 0x0D, 0x0A],
        "a pcapng capture; export it as text",
    ),
    (&[0xFF, 0xFE], "UTF-16 text; save it as UTF-8"),
    (&[0xFE, 0xFF], "UTF-16 text; save it as UTF-8"),
];

/// What a file is when it is no text.
pub(super) fn kind_of(begin: &[u8]) -> Option<&'static str> {
    let known = KINDS.iter().find(|(magic, _)| begin.starts_with(magic));
    known
        .map(|(_, what)| *what)
        .or_else(|| begin.contains(&0).then_some("binary data"))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn text_is_no_binary() {
        assert_eq!(kind_of(b"(0.0) can0 029#\n"), None);
        assert_eq!(kind_of("\u{feff}; Pr\u{fc}fstand".as_bytes()), None);
        assert_eq!(kind_of(b""), None);
        assert!(kind_of(b"LOGG\x90").is_some_and(|what| what.contains("BLF")));
        assert!(kind_of(b"\xFF\xFE(\0").is_some_and(|what| what.contains("UTF-16")));
        assert_eq!(kind_of(b"abc\0"), Some("binary data"));
    }
}
