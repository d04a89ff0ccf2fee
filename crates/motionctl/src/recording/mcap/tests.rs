//! The file read back with the reader of the crate; CI reads it with the Python package too.

use super::super::about::Origin;
use super::super::event::Kind;
use super::*;
use can_decode::Frame;
use dyn_can::DriveId;

fn about(names: &[&str]) -> About {
    let axis = |(name, drive): (&&str, DriveId)| AxisAbout {
        name: (*name).to_owned(),
        unit: "mm".to_owned(),
        counts_per_unit: 100.0,
        start: 7.0,
        ..AxisAbout::of_drive(drive)
    };
    let axes = names.iter().zip(DriveId::all()).map(axis).collect();
    About::now(Origin::Bus, axes, 1_000, 1_000)
}

fn axis(target: i32, position: Option<i64>) -> AxisSample {
    AxisSample {
        target,
        sent: target,
        position,
        backlog: 0,
        status_age_us: Some(1_500),
        position_age_us: None,
        state: None,
    }
}

/// Topic and message of everything in a file.
fn read(bytes: &[u8]) -> Vec<(String, serde_json::Value)> {
    let messages = mcap::MessageStream::new(bytes).unwrap();
    let message = |message: Result<mcap::Message<'_>, McapError>| {
        let message = message.unwrap();
        let schema = message.channel.schema.as_ref().unwrap();
        assert_eq!(schema.encoding, "jsonschema");
        assert_eq!(message.channel.message_encoding, "json");
        let value: serde_json::Value = serde_json::from_slice(&message.data).unwrap();
        let schema: serde_json::Value = serde_json::from_slice(&schema.data).unwrap();
        for name in schema["required"].as_array().unwrap() {
            assert!(
                value.get(name.as_str().unwrap()).is_some(),
                "{name} {value}"
            );
        }
        for name in value.as_object().unwrap().keys() {
            assert!(schema["properties"].get(name).is_some(), "{name} {schema}");
        }
        (message.channel.topic.clone(), value)
    };
    messages.map(message).collect()
}

#[test]
fn every_cycle_frame_and_event_is_there_in_the_unit_of_the_file() {
    let about = about(&["x", "y"]);
    let mut bytes = Vec::new();
    let mut file = McapFile::new(&mut bytes, &about).unwrap();
    for number in 0..3 {
        file.keep(&Item::Cycle(Sample {
            at_us: number * 1_000,
            number,
            load: 0.5,
            is_late: false,
            axes: vec![axis(1_000 + 100 * number as i32, None), axis(0, Some(-50))],
            wheels: Vec::new(),
        }))
        .unwrap();
    }
    let frame = Frame::new(0x029, false, &[]).unwrap();
    file.keep(&Item::Frame(WireFrame::ended(5, frame, Some(true), 1)))
        .unwrap();
    file.keep(&Item::Event(Happening {
        at_us: 9,
        axis: Some(1),
        kind: Kind::Fault,
        text: "lost".to_owned(),
        times: 1,
    }))
    .unwrap();
    file.finish().unwrap();
    drop(file);
    let messages = read(&bytes);
    let of = |topic: &str| -> Vec<&serde_json::Value> {
        let of_topic = messages.iter().filter(|(other, _)| other == topic);
        of_topic.map(|(_, value)| value).collect()
    };
    assert_eq!(of("/cycle").len(), 3);
    let targets: Vec<f64> = of("/axis/x")
        .iter()
        .map(|value| value["target"].as_f64().unwrap())
        .collect();
    assert_eq!(targets, [7.0, 8.0, 9.0]);
    assert_eq!(of("/axis/x")[0].get("position"), None);
    assert_eq!(of("/axis/y")[2]["following_error"], 0.5);
    assert_eq!(of("/frames")[0]["id"], 0x029);
    let text = of("/frames")[0]["text"].as_str().unwrap();
    assert!(text.contains("Read_Drive_Status"), "{text}");
    assert_eq!(of("/events")[0]["axis"], "y");
    assert_eq!(messages.len(), 3 * 3 + 2);
}

#[test]
fn topics_differ_whatever_the_columns_are_called() {
    let axes = about(&["x", "x", "a b/c", ""]).axes;
    assert_eq!(
        topics(&axes),
        ["/axis/x", "/axis/x.drive2", "/axis/a_b_c", "/axis/.drive4"]
    );
}
