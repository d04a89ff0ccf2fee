//! Lines as the tools wrote them.

use super::*;

/// Everything in a log: time in microseconds and text, or the error.
fn read(log: &str) -> Vec<String> {
    let mut reader = LogReader::new();
    let entries = log.lines().filter_map(|line| match reader.line(line) {
        Ok(entry) => entry.map(|entry| match entry.event {
            Event::Frame(frame) => format!("{} {} {frame}", entry.at_ns / 1_000, entry.interface),
            other => format!("{} {other:?}", entry.at_ns / 1_000),
        }),
        Err(error) => Some(format!("error: {error}")),
    });
    entries.collect()
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
    assert_eq!(
        read(";$FILEVERSION=1.3\n"),
        ["error: expected TRC version 1.0 or 2.1, got 1.3: save the log in one of these"]
    );
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
fn something_else_than_a_log_is_refused() {
    let errors = read("time_s,a,b\n");
    assert!(
        errors[0].starts_with("error: expected a log of candump -L"),
        "{errors:?}"
    );
    assert!(errors[0].ends_with("got \"time_s,a,b\""), "{errors:?}");
}
