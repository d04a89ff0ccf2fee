//! Damaged logs of every format, and what must hold for them; for the test and for the long run.

use can_decode::Decoder;
use can_decode::log::{Event, LogReader, Stamps};
use can_decode::statistics::Statistics;
use drive_sim::split_mix::SplitMix64;

/// Logs to be damaged.
const LOGS: [&str; 14] = [
    "(1.000000) can0 029#\n(1.000600) can0 029#00 R\n(1.1) can0 03C#1122334455667788_B\n(1.2) can0 029#R8_C\n(1.3) can0 20000004#000C\n(1.4) can0 029##100\n",
    " (000.000000)  can0  029   [0] \n (000.000621)  can0  RX - -  029   [1]  00\n (000.019000)  can0  029   {B}  00 01 02 03 04 05 06 07\n (000.000622)  can0  03C   [2]  FF`01\n",
    "  can0  029   [0] \n  can0  20000004   [8]  00 04 00 00 00 00 00 00   ERRORFRAME\n\tcontroller-problem{rx-error-warning}\n  can0  029   [4]  remote request\n",
    " (2026-11-28 10:00:00.000621)  \u{1b}[1m\u{1b}[34mcan0\u{1b}[0m  029   [1]  00000001\nDROPCOUNT: dropped 3 CAN frames on 'can0' socket (total drops 3)\n",
    "date Sat Nov 28 10:00:00.000 2026\nbase hex  timestamps relative\n 0.001000 1  29x Rx   d F 00 01 02 03 04 05 06 07\n 0.002 1 29 Tx r Length = 1704000\n 0.003 CANFD   1 Rx  29 name  0 0 1 1 00 0 0 200000 0\n 0.004 CANFD 1 Tx ErrorFrame text\n 0.008 2 OverloadFrame\n 0.009 CAN 1 Status:chip status error active\nEnd TriggerBlock\n",
    "base dec  timestamps absolute\n 0.1 1  60 Rx d 2 255 136\n",
    "timestamp,arbitration_id,extended,remote,error,dlc,data\n1732560000.15005,0x3c,0,0,0,2,/4g=\n5e-05,0x29,0,1,0,3,\n1,0x4,0,0,1,8,AAAAAAAAAAA=\n",
    "Time Stamp,ID,Extended,Dir,Bus,LEN,D1,D2,D3,D4,D5,D6,D7,D8\n39747828,0000003C,false,Rx,0,2,FF,88,00,00,00,00,00,00,\n1,00012345,true,Tx,1,1,01\n",
    "Timestamp: 1732560000.150050    ID:      03c    S Rx                DL:  2    ff 88                       Channel: can0\nTimestamp: 1.0        ID: 003c    S   R            DLC:  3\n",
    ";$FILEVERSION=2.1\n;$STARTTIME=46062.4\n;$COLUMNS=N,O,T,B,I,d,R,L,D\n 1 0.000 DT 1 0029 Rx - 1 00\n 2 0.1 RR 1 00000029 Rx - 4\n 3 0.2 ST 1 - Rx - 4 00 00 00 08\n",
    ";$FILEVERSION=2.0\n;$COLUMNS=N,O,T,I,d,l,D\n 1 0.0 DT 0029 Rx 0 \n",
    ";$FILEVERSION=1.3\n 1) 0.000 1 Rx 0029 - 1 00\n 2) 0.7 1 Warng FFFFFFFF - 4 00 00 00 08 BUSHEAVY\n",
    ";$FILEVERSION=1.1\n 1) 0.0 Tx 0029 0\n 2) 0.9 Error 0008 4 00 19 08 08\n",
    ";\n 1) 0 0029 0\n 2) 1 0008 4 ERROR 00 19 08 08\n 3) 2 FFFFFFFF 4 00 00 00 08\n",
];

/// Pieces that readers stumble over.
const PIECES: [&str; 24] = [
    "(",
    ")",
    "[",
    "]",
    "#",
    "##",
    ",",
    ".",
    "\n",
    "\r\n",
    "\t",
    " ",
    ";",
    "_",
    "`",
    "\u{1b}[",
    "\u{feff}",
    "\u{fffd}",
    "99999999999999999999",
    "-1",
    "1e308",
    "FFFFFFFF",
    "CANFD",
    "$COLUMNS=",
];

fn pick(random: &mut SplitMix64, count: usize) -> usize {
    random.up_to(count as u64 - 1) as usize
}

/// A log, damaged in a few places.
pub(crate) fn damaged(seed: u64) -> (String, Option<Stamps>) {
    let random = &mut SplitMix64::new(seed);
    let mut letters: Vec<char> = LOGS[pick(random, LOGS.len())].chars().collect();
    for _ in 0..random.up_to(5) {
        let place = pick(random, letters.len() + 1);
        let end = (place + pick(random, 30)).min(letters.len());
        match random.up_to(4) {
            0 => letters.truncate(place),
            1 => {
                letters.drain(place..end);
            }
            2 => {
                let copied = letters[place..end].to_vec();
                letters.splice(place..place, copied);
            }
            3 => letters.insert(
                place,
                char::from_u32(random.up_to(0x2FF) as u32).unwrap_or('\u{fffd}'),
            ),
            _ => {
                let piece = PIECES[pick(random, PIECES.len())];
                letters.splice(place..place, piece.chars());
            }
        }
    }
    let stamps = match random.up_to(7) {
        0 => Some(Stamps::Delta),
        1 => Some(Stamps::Zero),
        _ => None,
    };
    (letters.into_iter().collect(), stamps)
}

/// What a run found.
#[derive(Debug, Clone, Copy, Default)]
pub(crate) struct Tally {
    pub(crate) frames: u64,
    pub(crate) errors: u64,
}

/// Reads a log to its end or to the header that ends it, decodes its frames, and checks every error.
pub(crate) fn run(log: &str, stamps: Option<Stamps>) -> Result<Tally, String> {
    let mut reader = stamps.map_or_else(LogReader::new, LogReader::with_stamps);
    reader.look_ahead(log.lines());
    let (mut decoder, mut statistics) = (Decoder::default(), Statistics::default());
    let mut tally = Tally::default();
    for line in log.lines() {
        match reader.line(line) {
            Ok(None) => {}
            Ok(Some(entry)) => {
                if let Event::Frame(frame) = &entry.event {
                    let meaning = decoder.hear(entry.at_ns, frame);
                    statistics.count(entry.at_ns, frame, &meaning);
                    if meaning.to_string().is_empty() {
                        return Err(format!("no words for {frame}"));
                    }
                    tally.frames += 1;
                }
            }
            Err(error) => {
                let text = error.to_string();
                if text.contains(|letter: char| letter.is_control()) || text.len() > 400 {
                    return Err(format!("not one line of text: {text:?}"));
                }
                tally.errors += 1;
                if error.ends_log() {
                    break;
                }
            }
        }
    }
    if statistics.frames() != tally.frames {
        return Err(format!(
            "{} frames counted, {} read",
            statistics.frames(),
            tally.frames
        ));
    }
    Ok(tally)
}
