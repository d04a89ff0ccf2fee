//! The page of a small recording.

use super::*;
use crate::sim::recording::{AxisSample, Kind, Sample};
use drive_sim::{Bench, BitRate, ControllerConfig, DynDriveConfig, Frame, LogMode, TxOrder};
use embedded_can::{Frame as _, StandardId, nb::Can};

/// Two set-points to one drive, a sample a cycle, and an event.
fn recording() -> Recording {
    let (mut bench, _) =
        Bench::with_drives(BitRate::Kbit1000, [DynDriveConfig::numbered(1).unwrap()]);
    let master = bench.add_master(ControllerConfig::bxcan(TxOrder::Fifo));
    bench.bus_mut().set_log(LogMode::Full);
    let drives = dyn_can::DriveId::all().take(1).collect();
    let mut recording = Recording::new(drives, master, 1_000, 1_000);
    for cycle in 0..2 {
        bench.advance_to(cycle * 1_000_000);
        let frame = Frame::new(StandardId::new(0x03C).unwrap(), &[0x88]).unwrap();
        bench.port(master).transmit(&frame).unwrap();
        bench.advance_to(cycle * 1_000_000 + 500_000);
        let at_us = cycle * 1_000 + 1_000;
        recording.samples.push(sample(at_us));
    }
    for record in bench.bus_mut().log_mut().drain() {
        recording.frame(&record);
    }
    recording.happened(1_000, Some(0), Kind::Cause, "drive 1 </script> & <b>");
    recording
}

fn sample(at_us: u64) -> Sample {
    let axis = AxisSample {
        target: 100,
        sent: 90,
        drive: 80,
        backlog: 10,
        status_age_us: None,
        position_age_us: Some(2_000),
    };
    Sample {
        at_us,
        load: 0.25,
        is_late: true,
        axes: vec![axis],
    }
}

fn text() -> String {
    page::page(&recording(), &Summary::default(), None).unwrap()
}

#[test]
fn the_page_is_whole_and_loads_nothing() {
    let page = text();
    assert!(page.starts_with("<!DOCTYPE html>") && page.trim_end().ends_with("</html>"));
    assert!(
        !page.contains("{{") && !page.contains("}}"),
        "a place was not filled"
    );
    // The name space of SVG is a name and not an address that is loaded.
    let page = page.replace("http://www.w3.org/2000/svg", "");
    for outside in ["http:", "https:", "src=", "url(", "@import", "<link"] {
        assert!(!page.contains(outside), "{outside}");
    }
}

#[test]
fn every_axis_of_a_picture_has_its_unit() {
    let page = text();
    for label in [
        "position, counts",
        "error, counts",
        "backlog, counts",
        "oldest poll, ms",
        "bus load, %",
        "time, s",
        "less the cycle, us",
    ] {
        assert!(page.contains(label), "{label}");
    }
}

#[test]
fn colours_come_from_the_style_sheet() {
    let page = text();
    let pictures = page
        .split("<svg")
        .skip(1)
        .filter_map(|rest| rest.split("</svg>").next());
    let mut colors = 0;
    for picture in pictures {
        for part in picture.split("=\"#").skip(1) {
            let color = &part[..6];
            assert!(
                color.starts_with("0000"),
                "#{color} has no value in the dark"
            );
            colors += 1;
        }
    }
    assert!(colors > 50);
}

#[test]
fn texts_cannot_leave_their_place() {
    let page = text();
    assert!(page.contains("drive 1 &lt;/script&gt; &amp; &lt;b&gt;"));
    assert!(page.contains("drive 1: drive 1 \\u003c/script>"));
    assert_eq!(page.matches("</script>").count(), 2);
}

#[test]
fn what_is_said_again_and_again_is_counted() {
    let mut recording = recording();
    for at_us in [1_500, 1_600, 1_700] {
        recording.happened(at_us, None, Kind::Notice, "bus-off");
    }
    let page = page::page(&recording, &Summary::default(), None).unwrap();
    assert!(page.contains(">bus-off (3 times)<") && page.contains("0.001500"));
}

#[test]
fn a_text_is_in_the_page_once() {
    let page = text();
    assert_eq!(
        page.matches("p|03C 88|to drive 1    Go_Relative_Pos_PD: step by -120 counts")
            .count(),
        1
    );
    assert!(page.contains("The whole run, 2 frames."));
}
