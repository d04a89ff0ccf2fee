//! Lines as the tools wrote them.

use super::*;

/// Everything in a log: time in microseconds (`-` without one) and text, or the error.
fn read(log: &str) -> Vec<String> {
    read_with(LogReader::new(), log)
}

fn read_with(mut reader: LogReader, log: &str) -> Vec<String> {
    let mut texts = Vec::new();
    for line in log.lines() {
        match reader.line(line) {
            Ok(None) => {}
            Ok(Some(entry)) => {
                let us = entry
                    .at_ns
                    .map_or("-".to_owned(), |ns| (ns / 1_000).to_string());
                texts.push(match entry.event {
                    Event::Frame(frame) => format!("{us} {} {frame}", entry.interface),
                    other => format!("{us} {other:?}"),
                });
            }
            Err(error) => {
                texts.push(format!("error: {error}"));
                if error.ends_log() {
                    break;
                }
            }
        }
    }
    texts
}

#[test]
fn candump_log() {
    // python-can 4.6 CanutilsLogWriter; the first line as candump -L writes it.
    let log = "\
(1732560000.150050) can0 03C#FF88
(1732560000.151050) can0 029# T
(1732560000.152050) can0 029#01 R
(1732560000.153050) can0 00012345#01 R
(1732560000.154050) can0 029#R R
(1732560000.154060) can0 029#R3
(1732560000.155050) can0 20000080#0000000000000000
(1732560000.156050) can0 029##1000000000000000000000000 R
";
    assert_eq!(
        read(log),
        [
            "1732560000150050 can0 03C FF 88",
            "1732560000151050 can0 029",
            "1732560000152050 can0 029 01",
            "1732560000153050 can0 00012345 01",
            "1732560000154050 can0 029 R0",
            "1732560000154060 can0 029 R3",
            "1732560000155050 ErrorFrame",
            "1732560000156050 FdFrame",
        ]
    );
}

#[test]
fn candump_screen() {
    // candump -t a, with -a, with -x, remote, error and CAN FD frames.
    let log = "\
 (1732560000.150050)  can0  03C   [2]  FF 88
 (1732560000.150051)  can0  03C   [2]  FF 88   '..'
 (1732560000.150052)  can0  TX - -  029   [0]
 (1732560000.150053)  can0  0000003C   [1]  01
 (1732560000.150054)  can0  029   [4]  remote request
 (1732560000.150055)  can0  20000004   [8]  00 04 00 00 00 00 00 00   ERRORFRAME
 (1732560000.150056)  can0  029  [12]  00 00 00 00 00 00 00 00 00 00 00 00
";
    assert_eq!(
        read(log),
        [
            "1732560000150050 can0 03C FF 88",
            "1732560000150051 can0 03C FF 88",
            "1732560000150052 can0 029",
            "1732560000150053 can0 0000003C 01",
            "1732560000150054 can0 029 R4",
            "1732560000150055 ErrorFrame",
            "1732560000150056 FdFrame",
        ]
    );
}

#[test]
fn asc() {
    // python-can 4.6 ASCWriter.
    let log = "\
date Wed Nov 25 18:47:44.212 2026
base hex  timestamps absolute
internal events logged
Begin Triggerblock Mon Nov 25 18:40:00.150 2024
 0.000000 Start of measurement
 0.000000 1  3C              Rx   d 2 FF 88
 0.001000 1  29              Tx   d 0 
 0.003000 1  12345x          Rx   d 1 01
 0.004000 1  29              Rx   r 3 
 0.005000 1  ErrorFrame
 0.006000 CANFD   1 Rx         29                                   1 0 9 12 00 00 00 00 00 00 00 00 00 00 00 00        0    0     3000        0        0        0        0        0
End TriggerBlock
";
    assert_eq!(
        read(log),
        [
            "0 1 03C FF 88",
            "1000 1 029",
            "3000 1 00012345 01",
            "4000 1 029 R3",
            "5000 ErrorFrame",
            "6000 FdFrame",
        ]
    );
    let decimal = "base dec timestamps relative\n0.001 2 60 Rx d 2 255 136\n0.002 2 60 Rx d 0\n";
    assert_eq!(read(decimal), ["1000 2 03C FF 88", "3000 2 03C"]);
}

#[test]
fn asc_of_vector_tools() {
    // Kinds of lines after Vector's description of the format.
    let log = "\
date Sat Nov 28 10:00:00.000 am 2026
base hex  timestamps absolute
internal events logged
// version 9.0.0
Begin TriggerBlock Sat Nov 28 10:00:00.000 am 2026
   0.000000 Start of measurement
   0.002000 1 29 Tx r Length = 1704000 BitCount = 145 ID = 41
   0.002100 1 29 Tx r 4 Length = 1704000 BitCount = 145 ID = 41
   0.003000 1 29 Rx d F 00 01 02 03 04 05 06 07 Length = 228016 BitCount = 117 ID = 41
   0.003500 1 29 TxRq d 1 00
   0.004000 CANFD   1 Tx         29  ReadStatus                        0 0 0  0   242136  60   200000      dbc 46500250 460a0250 20011736 20010205
   0.005000 CANFD   1 Rx     12345x                                    0 0 1  1 21   230199  70   220000     62e7 46500250 460a0250 20011736 20010205
   0.006000 CANFD   1 Rx        300  Name_12                           1 0 8  8 01 02 03 04 05 06 07 08   102203  133   303000 e0006659 46500250 4b140250 20011736 2001040d
   0.007000 CANFD   3 Tx     50005x                                    0 0 5 0 140000 73 200050 7a60 46500250 460a0250 20011736 20010205
   0.008000 CANFD   5 Tx ErrorFrame Not Acknowledge error, dominant error flag fffe c7 31ca Arb. 556 44 0 0 f 0 0 0 0 0 0 0 0 0
   0.009000 1 ErrorFrame Flags = 0xe CodeExt = 0x20a2 Code = 0x82 ID = 0 DLC = 0 Position = 5 Length = 11300
   0.009100 2 OverloadFrame
   0.010000 CAN 1 Status:chip status error passive - TxErr: 132 RxErr: 0
   0.011000 1  Statistic: D 0 R 0 XD 0 XR 0 E 0 O 0 B 0.00%
   0.012000 1  J1939TP FEE3p        6    0  0   -   Rx   d 23 A0 0F A6
   0.013000 SV: 2 0 1 ::name = 1
   0.014000 Log Trigger event
End TriggerBlock
";
    assert_eq!(
        read(log),
        [
            "2000 1 029 R0",
            "2100 1 029 R4",
            "3000 1 029 00 01 02 03 04 05 06 07",
            "4000 1 029",
            "5000 1 00012345 21",
            "6000 FdFrame",
            "7000 3 00050005 R5",
            "8000 ErrorFrame",
            "9000 ErrorFrame",
            "9100 OverloadFrame",
            "10000 ControllerState",
        ]
    );
    let long = format!(
        "base hex timestamps absolute\n0.1 CANFD 4 Rx 4EE 0 0 f 64 {}0 0 0\n0.2 1 123x Rx d 40 {}\n",
        "00 ".repeat(64),
        "00 ".repeat(64)
    );
    assert_eq!(read(&long), ["100000 FdFrame", "200000 FdFrame"]);
    let damaged = "base hex timestamps absolute\n0.1 1 29\n0.1 1 29 Rz d 0\n0.1 1 Engine Rx d 0\n0.1 CANFD 1 Rx 29 0 0 1 1 00\nnoise\n";
    let errors = read(damaged);
    assert_eq!(errors.len(), 5, "{errors:?}");
    assert!(
        errors
            .iter()
            .all(|text| text.starts_with("error: expected")),
        "{errors:?}"
    );
}

#[test]
fn candump_screens_of_every_kind() {
    // sprint_timestamp and snprintf_long_canframe of can-utils.
    let frame = |us: &str, text: &str| vec![format!("{us} can0 {text}")];
    for (line, us, text) in [
        ("  can0  029   [1]  00", "-", "029 00"),
        ("  can0  TX - -  029   [1]  00", "-", "029 00"),
        (
            " (2026-11-28 10:00:00.123456)  can0  029   [1]  00",
            "1795860000123456",
            "029 00",
        ),
        (" (000.000621)  can0  029   [0] ", "621", "029"),
        (
            " (1795860000.123456789)  can0  029   [0] ",
            "1795860000123456",
            "029",
        ),
        (
            " (1795860000.123456)  \u{1b}[1m\u{1b}[34mcan0\u{1b}[0m  029   [1]  00",
            "1795860000123456",
            "029 00",
        ),
        (
            " (1795860000.123456)  \u{1b}[1m\u{1b}[34mcan0  029   [1]  00\u{1b}[0m",
            "1795860000123456",
            "029 00",
        ),
        (
            " \u{1b}[1m\u{1b}[34m(1795860000.123456)  can0  029   [1]  00\u{1b}[0m",
            "1795860000123456",
            "029 00",
        ),
        ("  can0  029   {1}  00", "-", "029 00"),
        (
            "  can0  029   {B}  00 01 02 03 04 05 06 07",
            "-",
            "029 00 01 02 03 04 05 06 07",
        ),
        ("  can0  03C   [2]  00000001 11111111", "-", "03C 01 FF"),
        ("  can0  03C   [2]  FF`01", "-", "03C 01 FF"),
        ("  can0  03C   [2]  01 FF   '..'", "-", "03C 01 FF"),
        ("  can0  029   [4]  remote request", "-", "029 R4"),
    ] {
        assert_eq!(read(line), frame(us, text), "{line:?}");
    }
    let error_frame = "  can0  20000004   [8]  00 04 00 00 00 00 00 00   ERRORFRAME\n\tcontroller-problem{rx-error-warning}\n";
    assert_eq!(read(error_frame), ["- ErrorFrame"]);
    let lost =
        "(1.0) can0 029#\nDROPCOUNT: dropped 3 CAN frames on 'can0' socket (total drops 3)\n";
    assert!(read(lost)[1].starts_with("error: frames are missing here"));
    let mixed = "  can0  029   [0] \n (000.1)  can0  029   [0] \n";
    assert!(read(mixed)[1].starts_with("error: expected no time, as in the lines before"));
}

#[test]
fn candump_logs_with_length_codes() {
    for (line, text) in [
        (
            "(1.0) can0 03C#1122334455667788_B",
            "1000000 can0 03C 11 22 33 44 55 66 77 88",
        ),
        ("(1.0) can0 029#R8_C", "1000000 can0 029 R8"),
        ("(1.0) can0 03C#11.22", "1000000 can0 03C 11 22"),
    ] {
        assert_eq!(read(line), [text]);
    }
    for line in [
        "(1.0) can0 03C#1122_B",
        "(1.0) can0 03C#1122334455667788_8",
        "(1.0) can0 029# 029#",
    ] {
        assert!(read(line)[0].starts_with("error: expected"), "{line}");
    }
}

#[test]
fn differences_are_told_from_times_by_their_order() {
    let log = " (000.000000)  can0  029   [0] \n (000.000621)  can0  029   [1]  00\n (000.019000)  can0  029   [0] \n (000.000622)  can0  029   [1]  00\n";
    let mut reader = LogReader::new();
    reader.look_ahead(log.lines());
    let sums = [
        "0 can0 029",
        "621 can0 029 00",
        "19621 can0 029",
        "20243 can0 029 00",
    ];
    assert_eq!(read_with(reader, log), sums);
    assert_eq!(read_with(LogReader::with_stamps(Stamps::Delta), log), sums);
    // Nothing was looked at: the first that goes back ends the log.
    let texts = read(log);
    assert_eq!(texts.len(), 4);
    assert!(texts[3].contains("--stamps delta"), "{texts:?}");
    let zero = read_with(LogReader::with_stamps(Stamps::Zero), log);
    assert_eq!(zero[3], "622 can0 029 00");
}

#[test]
fn gvret() {
    // SavvyCAN's saveNativeCSVFile, and its first version without Dir.
    let log = "\
Time Stamp,ID,Extended,Dir,Bus,LEN,D1,D2,D3,D4,D5,D6,D7,D8
39747828,0000003C,false,Rx,0,2,FF,88,00,00,00,00,00,00,
39748828,00012345,true,Tx,1,1,01,00,00,00,00,00,00,00,
";
    let frames = ["39747828 0 03C FF 88", "39748828 1 00012345 01"];
    assert_eq!(read(log), frames);
    let first = "Time Stamp,ID,Extended,Bus,LEN,D1,D2,D3,D4,D5,D6,D7,D8\n39747828,0000003C,false,0,2,FF,88,,,,,,\n";
    assert_eq!(read(first), frames[..1]);
    let permuted = "LEN,D8,D7,D6,D5,D4,D3,D2,D1,Bus,ID,Extended,Time Stamp\n2,0,0,0,0,0,0,88,FF,0,3C,false,39747828\n";
    assert_eq!(read(permuted), frames[..1]);
    let damaged = "Time Stamp,ID,Extended,Dir,Bus,LEN,D1,D2,D3,D4,D5,D6,D7,D8\n1,3C,maybe,Rx,0,0\n1,3C,false,Rx,0,2,FF\n1,900,false,Rx,0,0,\n";
    assert!(
        read(damaged)
            .iter()
            .all(|text| text.starts_with("error: expected"))
    );
}

#[test]
fn csv() {
    // python-can 4.6 CSVWriter.
    let log = "\
timestamp,arbitration_id,extended,remote,error,dlc,data
1732560000.15005,0x3c,0,0,0,2,/4g=
5e-05,0x29,0,0,0,0,
1732560000.15305,0x12345,1,0,0,1,AQ==
1732560000.15405,0x29,0,1,0,3,
1732560000.15505,0x4,0,0,1,8,AAAAAAAAAAA=
1732560000.15605,0x29,0,0,0,12,AAAAAAAAAAAAAAAA
";
    assert_eq!(
        read(log),
        [
            "1732560000150050  03C FF 88",
            "50  029",
            "1732560000153050  00012345 01",
            "1732560000154050  029 R3",
            "1732560000155050 ErrorFrame",
            "1732560000156050 FdFrame",
        ]
    );
}

#[test]
fn printer() {
    // python-can 4.6 Printer.
    let log = "\
Timestamp: 1732560000.150050    ID:      03c    S Rx                DL:  2    ff 88                       Channel: can0
Timestamp: 1732560000.151050    ID:      029    S Tx                DL:  0                                Channel: can0
Timestamp: 1732560000.153050    ID: 00012345    X Rx                DL:  1    01                          Channel: can0
Timestamp: 1732560000.154050    ID:      029    S Rx   R            DL:  3                                Channel: can0
Timestamp: 1732560000.155050    ID:      004    S Rx E              DL:  8    00 00 00 00 00 00 00 00     Channel: can0
Timestamp: 1732560000.156050    ID:      029    S Rx     F BS       DL: 12    00 00 00 00 00 00 00 00 00 00 00 00    Channel: can0
";
    assert_eq!(
        read(log),
        [
            "1732560000150050 can0 03C FF 88",
            "1732560000151050 can0 029",
            "1732560000153050 can0 00012345 01",
            "1732560000154050 can0 029 R3",
            "1732560000155050 ErrorFrame",
            "1732560000156050 FdFrame",
        ]
    );
}

#[test]
fn printer_of_version_3() {
    // python-can 3.3 Message.__str__.
    let log = "\
Timestamp: 1732560000.150050        ID: 003c    S                DLC:  2    ff 88                       Channel: can0
Timestamp: 1732560000.153050    ID: 00012345    X                DLC:  1    01                          Channel: can0
Timestamp: 1732560000.154050        ID: 0029    S   R            DLC:  3                                Channel: can0
Timestamp: 1732560000.155050        ID: 0004    S E              DLC:  8    00 00 00 00 00 00 00 00     Channel: can0
";
    assert_eq!(
        read(log),
        [
            "1732560000150050 can0 03C FF 88",
            "1732560000153050 can0 00012345 01",
            "1732560000154050 can0 029 R3",
            "1732560000155050 ErrorFrame",
        ]
    );
}

#[test]
fn a_byte_order_mark_is_no_part_of_the_first_line() {
    assert_eq!(
        read("\u{feff}(0.0) can0 029#\n(0.1) can0 029#00\n"),
        ["0 can0 029", "100000 can0 029 00"]
    );
    assert_eq!(
        read("\u{feff};$FILEVERSION=1.1\n 1) 0.0 Rx 0029 0\n"),
        ["0 1 029"]
    );
}

#[test]
fn trc() {
    // python-can 4.6 TRCWriter, versions 2.1 and 1.0.
    let new = "\
;$FILEVERSION=2.1
;$STARTTIME=45621.777779514465
;$COLUMNS=N,O,T,B,I,d,R,L,D
;---+-- ------+------ +- +- --+----- +- +- +--- +- -- -- -- -- -- -- --
      0         0.000 DT  1     003C Rx -  2    FF 88
      1         1.250 DT  1     0029 Tx -  0    
      3         3.000 DT  1  0012345 Rx -  1    01
";
    assert_eq!(
        read(new),
        ["0 1 03C FF 88", "1250 1 029", "3000 1 00012345 01"]
    );
    let old = "\
;##########################################################################
;    Generated by python-can TRCWriter
     0)       0     003C 2 FF 88
     1)       1     0029 0 
     3)       3  0012345 1 01
     4)       4     0029 4 RTR
";
    assert_eq!(
        read(old),
        [
            "0 1 03C FF 88",
            "1000 1 029",
            "3000 1 00012345 01",
            "4000 1 029 R4"
        ]
    );
}

#[test]
fn trc_of_every_version() {
    // Lines after PEAK's description of the format, and of its own tools.
    let frames = [
        "0 1 029",
        "600 1 029 00",
        "700 1 00000029 R4",
        "800 ControllerState",
        "900 ErrorFrame",
    ];
    let old = |version: &str, lines: &str| {
        format!(";$FILEVERSION={version}\n;$STARTTIME=46062.4\n;\n{lines}")
    };
    for log in [
        old(
            "1.1",
            "     1)         0.0  Tx         0029  0  \n     2)         0.6  Rx         0029  1  00 \n     3)         0.7  Rx     00000029  4  RTR\n     4)         0.8  Warng  FFFFFFFF  4  00 00 00 08  BUSHEAVY \n     5)         0.9  Error      0008  4  00 19 08 08\n",
        ),
        old(
            "1.2",
            "     1)         0.0 1  Tx         0029  0  \n     2)         0.6 1  Rx         0029  1  00 \n     3)         0.7 1  Rx     00000029  4  RTR\n     4)         0.8 1  Warng  FFFFFFFF  4  00 00 00 08  BUSHEAVY \n     5)         0.9 1  Error      0008  4  00 19 08 08\n",
        ),
        old(
            "1.3",
            "     1)         0.000 1  Tx        0029 -  0    \n     2)         0.600 1  Rx        0029 -  1    00\n     3)         0.700 1  Rx    00000029 -  4    RTR\n     4)         0.800 1  Warng FFFFFFFF -  4    00 00 00 08 BUSHEAVY\n     5)         0.900 1  Error     0008 -  4    00 19 08 08\n",
        ),
        old(
            "2.0",
            ";$COLUMNS=N,O,T,I,d,l,D\n      1         0.000 DT     0029 Tx 0  \n      2         0.600 DT     0029 Rx 1  00 \n      3         0.700 RR 00000029 Rx 4  \n      4         0.800 ST          Rx    00 00 00 08\n      5         0.900 ER          Rx    04 00 02 00 00\n",
        ),
        old(
            "2.1",
            ";$COLUMNS=N,O,T,B,I,d,R,L,D\n      1         0.000 DT 1     0029 Tx -  0    \n      2         0.600 DT 1     0029 Rx -  1    00 \n      3         0.700 RR 1 00000029 Rx -  4    \n      4         0.800 ST 1        - Rx -  4    00 00 00 08\n      5         0.900 ER 1        - Rx -  5    04 00 02 00 00\n",
        ),
        old(
            "2.1",
            ";$COLUMNS=B,I,d,T,O,l,D\n1 0029 Tx DT 0.000 0\n1 0029 Rx DT 0.6 1 00\n1 00000029 Rx RR 0.7 4\n",
        ),
    ] {
        let actual = read(&log);
        assert_eq!(actual, frames[..actual.len()], "{log}");
        assert!(actual.len() >= 3, "{log}");
    }
    // Version 1.0 has its states and errors among the frames, and neither type nor version.
    let oldest = ";\n     1)       0      0029  0\n     2)       1  0008  4 ERROR 00 19 08 08\n     3)       2  FFFFFFFF  4  00 00 00 08 -- -- -- -- BUSHEAVY\n";
    assert_eq!(
        read(oldest),
        ["0 1 029", "1000 ErrorFrame", "2000 ControllerState"]
    );
}

#[test]
fn a_header_that_nobody_can_read_ends_the_log_with_one_error() {
    for (log, expected) in [
        (
            ";$FILEVERSION=3.0\n1 2 3\n1 2 3\n",
            "expected TRC version 1.0, 1.1, 1.2, 1.3, 2.0 or 2.1, got \"3.0\"",
        ),
        (
            ";$FILEVERSION=2.1\n;$COLUMNS=N,O,T,X,D\n1 2 3\n",
            "expected the columns O, T, I, l or L, and D at the end",
        ),
        (
            ";$FILEVERSION=2.1\n;$COLUMNS=N,O,T,D,I,L\n1 2 3\n",
            "expected the columns O, T, I, l or L, and D at the end",
        ),
        (
            ";$FILEVERSION=2.1\n;$COLUMNS=N,O,T,I,I,L,D\n1 2 3\n",
            "expected the columns O, T, I, l or L, and D at the end",
        ),
        (
            ";$FILEVERSION=2.1\n 1 0.000 DT 1 0029 Rx - 0\n",
            "expected a line ;$COLUMNS= before the first frame",
        ),
        (
            "base oct  timestamps absolute\n0.1 1 29 Rx d 0\n",
            "expected base hex or dec, timestamps absolute or relative",
        ),
        (
            "base hex  timestamps monotone\n0.1 1 29 Rx d 0\n",
            "expected base hex or dec, timestamps absolute or relative",
        ),
    ] {
        let errors = read(log);
        assert_eq!(errors.len(), 1, "{errors:?}");
        assert!(
            errors[0].starts_with(&format!("error: {expected}")),
            "{errors:?}"
        );
    }
}

#[test]
fn a_damaged_line_is_named_and_the_next_one_is_read() {
    let log = "\
(1.000000) can0 03C#FF88
(1.0000
(1.001000) can0
(1.002000) can0 03C#FF8
(1.003000) can0 03C#FFGG
(1.004000) can0 900#00
(1.005000) can0 03C#000102030405060708
(1.006000) can0 03C [2] FF
1.007000 can0 03C#FF
(x) can0 03C#FF
\u{fffd}\u{fffd}
(1.008000) can0 03C#FF88
";
    assert_eq!(
        read(log),
        [
            "1000000 can0 03C FF 88",
            "error: expected a time in brackets, got \"(1.0000\"",
            "error: expected a frame, the line ends",
            "error: expected a data byte, got \"FF8\"",
            "error: expected a data byte, got \"FFGG\"",
            "error: expected an identifier of at most 11 bits, got \"0x900\"",
            "error: expected 8 data bytes, got 9",
            "error: expected 2 data bytes, got 1",
            "error: expected a time in brackets, got \"1.007000\"",
            "error: expected a time, got \"x\"",
            "error: expected a time in brackets, got \"\u{fffd}\u{fffd}\"",
            "1008000 can0 03C FF 88",
        ]
    );
}

#[test]
fn a_first_line_that_was_cut_does_not_cost_the_log() {
    let texts = read("(1.0) can0 029#\n");
    let cut = read(".0) can0 029#\n(1.0) can0 029#\n");
    assert!(cut[0].starts_with("error: expected a log of"), "{cut:?}");
    assert_eq!(cut[1..], texts);
    for header in [
        "timestamp,arbitration_id,dlc,data\n1,0x29,0,\n",
        "Time Stamp,ID,Extended,Bus,LEN\n1,29,false,0,0\n",
    ] {
        assert!(
            read(header)
                .iter()
                .all(|text| text.starts_with("error: expected a log of"))
        );
    }
}

#[test]
fn something_else_than_a_log_is_refused() {
    let errors = read("time_s,a,b\n");
    assert!(
        errors[0].starts_with("error: expected a log of candump, "),
        "{errors:?}"
    );
    assert!(errors[0].ends_with("got \"time_s,a,b\""), "{errors:?}");
}

#[test]
fn more_data_than_the_length_says_is_no_frame() {
    let gvret = "Time Stamp,ID,Extended,Dir,Bus,LEN,D1,D2,D3,D4,D5,D6,D7,D8";
    for log in [
        ";$FILEVERSION=1.1\n1) 1.0 Rx 0029 1 00 11 22".to_owned(),
        ";$FILEVERSION=2.1\n;$COLUMNS=N,O,T,I,d,L,D\n1 1.0 DT 0029 Rx 1 00 11".to_owned(),
        "base hex timestamps absolute\n0.1 1 29 Rx d 1 00 11".to_owned(),
        "base dec timestamps absolute\n0.1 1 41 Rx d 1 0 171 Length = 1".to_owned(),
        "  can0  029   [1]  00 11".to_owned(),
        "Timestamp: 0.1 ID: 029 S Rx DL: 1 00 11 Channel: can0".to_owned(),
        format!("{gvret}\n1000,00000029,false,Rx,0,1,00,11,00,00,00,00,00,00,"),
    ] {
        assert_eq!(
            read(&log),
            ["error: expected 1 data bytes, got 2"],
            "{log:?}"
        );
    }
    // What tools write behind the data.
    for log in [
        "base hex timestamps absolute\n0.1 1 29 Rx d 1 00  Length = 230000 BitCount = 119 ID = 41",
        "  can0  029   [1]  41   'A'",
        "Timestamp: 0.1 ID: 029 S Rx DL: 1 41 'A' Channel: 0",
    ] {
        let entries = read(log);
        assert!(
            entries.len() == 1 && !entries[0].starts_with("error"),
            "{log:?}: {entries:?}"
        );
    }
}

#[test]
fn an_identifier_of_candump_has_three_or_eight_digits() {
    for id in ["0029", "00029", "0000029", "000000029"] {
        for line in [
            format!("(1.0) can0 {id}#00"),
            format!("  can0  {id}   [1]  00"),
        ] {
            let expected = format!("error: expected an identifier of 3 or 8 digits, got \"{id}\"");
            assert_eq!(read(&line), [expected], "{line:?}");
        }
    }
    assert_eq!(
        read("(1.0) can0 029#00\n(1.0) can0 00000029#00"),
        ["1000000 can0 029 00", "1000000 can0 00000029 00",]
    );
}

#[test]
fn what_an_fd_channel_of_asc_says_beside_its_flags() {
    let line = |text: &str| format!("base hex timestamps absolute\n0.1 CANFD 1 {text}");
    // The bit rate switch or the error state without flags.
    for bits in ["1 0", "0 1"] {
        let text = line(&format!("Rx 29 {bits} 1 1 00 0 0 0 0 0 0 0 0"));
        assert_eq!(read(&text), ["100000 FdFrame"], "{text}");
    }
    // A request to send is not on the bus yet.
    assert_eq!(read(&line("TxRq 29 0 0 1 1 00 0 0 0 0 0 0 0 0")), [""; 0]);
    assert_eq!(
        read(&line("Tx 29 0 0 1 1 00 0 0 0 0 0 0 0 0")),
        ["100000 1 029 00"]
    );
}

#[test]
fn a_length_of_csv_that_contradicts_its_data_is_damage() {
    let header = "timestamp,arbitration_id,extended,remote,error,dlc,data";
    assert_eq!(
        read(&format!(
            "{header}\n0.1,0x29,0,0,0,2,AA==\n0.2,0x29,0,0,0,1,AA=="
        )),
        ["error: expected 2 data bytes, got 1", "200000  029 00"]
    );
}

#[test]
fn gvret_of_other_writers() {
    let header = "Time Stamp,ID,Extended,Dir,Bus,LEN,D1,D2,D3,D4,D5,D6,D7,D8";
    let lines = "1000,0x00000029,false,Rx,0,2,0x01,0xFF,0x00,0x00,0x00,0x00,0x00,0x00\n2000,29,0,Tx,0,1,0A,";
    assert_eq!(
        read(&format!("{header}\n{lines}")),
        ["1000 0 029 01 FF", "2000 0 029 0A"]
    );
    assert_eq!(
        read(&format!("{header}\n1000,0x,false,Rx,0,1,0x00")),
        ["error: expected an identifier, got \"\""]
    );
}
