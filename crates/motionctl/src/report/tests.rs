//! The page of a small recording. What it looks like is checked in a browser: `cargo xtask ci report-page`.

use super::*;
use crate::recording::Origin;
use crate::recording::{About, AxisAbout, AxisSample, Happening, Item, Kind, Sample, WireFrame};
use can_decode::Frame;
use dyn_can::DriveId;

fn recording() -> Recording {
    let axes = DriveId::all().take(1).map(AxisAbout::of_drive).collect();
    let mut recording = Recording::new(About::now(Origin::Simulation, axes, 1_000, 1_000));
    for number in 0..2 {
        let frame = Frame::new(0x03C, false, &[0x88]).unwrap();
        let end_ns = number * 1_000_000 + 500_000;
        recording.add(&Item::Frame(WireFrame::ended(
            end_ns,
            frame,
            Some(true),
            1_000,
        )));
        recording.add(&Item::Cycle(Sample {
            at_us: number * 1_000 + 1_000,
            number,
            load: 0.25,
            is_late: true,
            axes: vec![AxisSample {
                target: 100,
                sent: 90,
                position: Some(80),
                backlog: 10,
                status_age_us: None,
                position_age_us: Some(2_000),
                state: None,
            }],
            wheels: Vec::new(),
        }));
    }
    recording.add(&Item::Event(Happening {
        at_us: 1_000,
        axis: Some(0),
        kind: Kind::Cause,
        text: "drive 1 </script> & <b> {{data}}".to_owned(),
        times: 1,
    }));
    recording
}

fn page() -> String {
    text(&recording(), &Outcome::default())
}

#[test]
fn the_page_is_whole_and_loads_nothing() {
    let page = page();
    assert!(page.starts_with("<!DOCTYPE html>") && page.trim_end().ends_with("</html>"));
    for place in ["{{style}}", "{{script}}"] {
        assert!(!page.contains(place), "{place} was not filled");
    }
    // The name space of SVG is a name, and the place of a clip path is in the page.
    let page = page
        .replace("http://www.w3.org/2000/svg", "")
        .replace("url(#", "");
    for outside in [
        "http:", "https:", "src=", "url(", "@import", "<link", "fetch(",
    ] {
        assert!(!page.contains(outside), "{outside}");
    }
}

#[test]
fn texts_cannot_leave_their_place() {
    let page = page();
    assert!(page.contains(r"drive 1 \u003c/script> & \u003cb> {{data}}"));
    assert_eq!(page.matches("</script>").count(), 2);
    assert!(!page.contains("innerHTML"), "texts would be read as HTML");
}

#[test]
fn a_text_is_in_the_page_once() {
    let page = page();
    let text = "p|03C 88|to drive 1    Go_Relative_Pos_PD: step by -120 counts";
    assert_eq!(page.matches(text).count(), 1);
}

#[test]
fn there_is_one_block_of_numbers_and_it_tells_the_run_from_others() {
    let page = page();
    assert_eq!(page.matches("type=\"application/json\"").count(), 1);
    let block = page.split("id=\"data\">").nth(1).unwrap();
    let block = block.split("</script>").next().unwrap();
    let data: serde_json::Value = serde_json::from_str(block).unwrap();
    let names: Vec<_> = data["about"]
        .as_array()
        .unwrap()
        .iter()
        .map(|fact| fact[0].as_str().unwrap().to_owned())
        .collect();
    assert_eq!(names, ["command line", "version", "date", "seed"]);
    assert_eq!(data["samples"]["count"], 2);
    assert_eq!(data["axes"][0]["unit"], "counts");
}
