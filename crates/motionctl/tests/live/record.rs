//! `motionctl record` on an adapter that only listens.

use std::time::{Duration, Instant};

use serde_json::Value;

use crate::bench::{interrupt, motionctl, scratch, status_and_errors};
use crate::terminal::Terminal;
use crate::tool::{Folder, motionctl as tool};

/// Frames that the adapter hears.
const FRAMES: usize = 60_000;

/// Answers as an adapter does that is opened to listen, then sends frames as fast as they are taken.
fn serve(terminal: &mut Terminal, child: &mut std::process::Child) {
    let (mut to_send, mut line, mut sent) = (Vec::new(), Vec::new(), None);
    let start = Instant::now();
    while sent != Some(FRAMES) || !to_send.is_empty() {
        assert!(
            start.elapsed() < Duration::from_secs(60),
            "still at frame {sent:?}"
        );
        assert!(child.try_wait().expect("its status").is_none(), "it ended");
        for byte in terminal.read() {
            if byte != b'\r' {
                line.push(byte);
                continue;
            }
            assert_ne!(line.first(), Some(&b'O'), "a listener must not acknowledge");
            match line.first() {
                Some(b'V') => to_send.extend(b"V1013\r"),
                Some(b'L') => {
                    to_send.extend(b"\r");
                    sent = Some(0);
                }
                Some(_) => to_send.extend(b"\r"),
                None => {}
            }
            line.clear();
        }
        if let Some(count) = &mut sent
            && to_send.len() < 1_000
            && *count < FRAMES
        {
            to_send.extend(format!("t03C2{:04X}\r", *count % 0x1_0000).bytes());
            *count += 1;
        }
        terminal.write(&mut to_send, None);
    }
}

fn lines_of(folder: &Folder) -> Vec<usize> {
    let entries = std::fs::read_dir(&folder.0).expect("the folder");
    let mut paths: Vec<_> = entries.map(|entry| entry.expect("a file").path()).collect();
    paths.sort();
    let lines = |path: &std::path::PathBuf| {
        let text = std::fs::read_to_string(path).expect("a log");
        assert!(text.is_empty() || text.ends_with('\n'), "whole lines");
        text.lines().count()
    };
    paths.iter().map(lines).collect()
}

#[test]
fn every_frame_is_in_a_file_and_the_files_rotate() {
    let folder = Folder::new("record");
    let link = scratch("record-adapter");
    let mut terminal = Terminal::new(&link);
    let words = [
        "record",
        "--slcan",
        link.to_str().expect("plain text"),
        "--folder",
        folder.as_str(),
        "--file-mb",
        "1",
        "--keep",
        "2",
        "--least-free-mb",
        "1",
        "--json",
    ];
    let mut child = motionctl(&words).spawn().expect("motionctl starts");
    serve(&mut terminal, &mut child);
    // What is in the line is read before the signal is seen.
    std::thread::sleep(Duration::from_secs(2));
    interrupt(&child);
    let output = child.wait_with_output().expect("its output");
    let (status, errors) = status_and_errors(&output);
    assert_eq!(status, Some(0), "{errors}");
    let summary: Value = serde_json::from_slice(&output.stdout).expect("JSON");
    let count = |name: &str| summary[name].as_u64().expect("a count") as usize;
    assert_eq!(
        (count("frames"), count("lost_frames")),
        (FRAMES, 0),
        "{summary}"
    );
    let lines = lines_of(&folder);
    // 37 bytes a line: more than two files of a megabyte.
    assert_eq!((count("files"), lines.len()), (3, 2), "{summary}");
    assert_eq!(
        lines.iter().sum::<usize>() + count("removed_frames"),
        FRAMES
    );
    let newest = summary["newest_file"].as_str().expect("a path");
    let decoded = tool(&["decode", newest, "--statistics-only"]);
    assert!(decoded.status.success(), "{decoded:?}");
    let _ = std::fs::remove_file(link);
}

#[test]
fn a_disk_without_room_is_refused_before_the_bus_is_opened() {
    let folder = Folder::new("record-full");
    // More than any disk has.
    let words = [
        "record",
        "--slcan",
        "/dev/no-such-port",
        "--folder",
        folder.as_str(),
        "--least-free-mb",
        "1000000000000",
    ];
    let output = motionctl(&words).output().expect("motionctl runs");
    let (status, errors) = status_and_errors(&output);
    assert_eq!(status, Some(2), "{errors}");
    assert!(errors.contains("MB are left on the disk"), "{errors}");
}
