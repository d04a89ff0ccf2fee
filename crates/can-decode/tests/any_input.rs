//! Nothing that a log or a bus can hold makes the reader or the decoder panic.

use can_decode::log::{Event, LogReader};
use can_decode::statistics::Statistics;
use can_decode::{Decoder, Frame};
use proptest::prelude::*;

/// First lines of every format.
const BEGINNINGS: [&str; 6] = [
    "(1.000000) can0 03C#FF88",
    "base hex  timestamps relative",
    "timestamp,arbitration_id,extended,remote,error,dlc,data",
    "Timestamp: 1.0 ID: 03c S Rx DL: 2 ff 88 Channel: can0",
    ";$FILEVERSION=1.3",
    ";a TRC of version 1.0",
];

/// Lines of every format, to be damaged.
const LINES: [&str; 8] = [
    "(1732560000.150050) can0 03C#FF88 R",
    " (1732560000.150050)  can0  RX - -  03C   [2]  FF 88",
    "0.001000 1  12345x          Rx   d 1 01",
    "1732560000.15005,0x3c,0,0,0,2,/4g=",
    "Timestamp: 1732560000.150050    ID:      03c    S Rx                DL:  2    ff 88    Channel: can0",
    "      0         0.000 DT  1     003C Rx -  2    FF 88",
    "     0)       0     003C 2 FF 88",
    "0.006000 CANFD   1 Rx  29",
];

proptest! {
    #[test]
    fn any_text_is_read_or_refused(beginning in prop::sample::select(&BEGINNINGS), lines in prop::collection::vec(".{0,60}", 0..20)) {
        let mut reader = LogReader::new();
        prop_assert!(reader.line(beginning).is_ok());
        for line in &lines {
            let _ = reader.line(line);
        }
    }

    #[test]
    fn a_damaged_line_is_read_or_refused_and_the_next_one_is_read(
        line in prop::sample::select(&LINES), place in 0_usize..60, new in any::<char>(), cut in 0_usize..100,
    ) {
        let damaged: String = line.chars().enumerate().map(|(n, old)| if n == place { new } else { old }).take(cut).collect();
        for beginning in BEGINNINGS {
            let mut reader = LogReader::new();
            reader.line(beginning).expect("an undamaged line");
            let format = reader.format();
            let _ = reader.line(&damaged);
            let again = reader.line(beginning);
            prop_assert!(again.is_ok() && reader.format() == format);
        }
    }

    #[test]
    fn any_frames_at_any_times_have_words(
        frames in prop::collection::vec((any::<u64>(), 0_u32..0x800, any::<bool>(), prop::collection::vec(any::<u8>(), 0..=8)), 1..50)
    ) {
        let (mut decoder, mut statistics) = (Decoder::default(), Statistics::default());
        for (at_ns, id, extended, data) in &frames {
            let frame = Frame::new(*id, *extended, data).expect("at most 11 bits and 8 bytes");
            let meaning = decoder.hear(*at_ns, &frame);
            statistics.count(*at_ns, &frame, &meaning);
            prop_assert!(!meaning.to_string().is_empty());
            prop_assert!(serde_json::to_string(&meaning).is_ok());
        }
        prop_assert_eq!(statistics.frames(), frames.len() as u64);
        let each: u64 = statistics.identifiers().map(|(_, _, entry)| entry.frames()).sum();
        prop_assert_eq!(each, frames.len() as u64);
    }

    #[test]
    fn what_is_written_as_candump_is_read_back(at_us in 0..u64::from(u32::MAX), id in 0_u32..0x800, data in prop::collection::vec(any::<u8>(), 0..=8)) {
        let frame = Frame::new(id, false, &data).expect("a frame");
        let bytes: String = data.iter().map(|byte| format!("{byte:02X}")).collect();
        let line = format!("({}.{:06}) can0 {id:03X}#{bytes}", at_us / 1_000_000, at_us % 1_000_000);
        let mut reader = LogReader::new();
        let entry = reader.line(&line).expect("a line").expect("an entry");
        prop_assert_eq!((entry.at_ns, entry.event), (Some(at_us * 1_000), Event::Frame(frame)));
    }
}
