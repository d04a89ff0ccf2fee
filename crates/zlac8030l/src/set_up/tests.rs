use super::*;
use crate::abort::AbortCode;
use crate::node::PdoNumber;
use crate::object::ObjectValue;
use crate::object::WidthError;
use crate::pdo::{MappingEntry, PdoDirection, PdoMapping};
use std::collections::BTreeMap;
use std::vec::Vec;

/// A drive that keeps what is written, and the transfers it saw.
struct Memory {
    values: BTreeMap<ObjectAddress, ObjectData>,
    writes: Vec<(ObjectAddress, u32)>,
    /// The confirmation of the next write to this object is lost.
    mute: Option<ObjectAddress>,
    /// Writes to this object change nothing.
    deaf: Option<ObjectAddress>,
}

impl Memory {
    fn factory() -> Self {
        let entries = dictionary::entries().filter_map(|entry| {
            let value = entry.default.of(crate::NodeId::FACTORY).unwrap_or(0);
            Some((entry.address, entry.data_type.data(value)?))
        });
        Self {
            values: entries.collect(),
            writes: Vec::new(),
            mute: None,
            deaf: None,
        }
    }

    fn answer(&mut self, request: SdoRequest) -> SdoEnd {
        match request {
            SdoRequest::Read(address) => self
                .values
                .get(&address)
                .map_or(SdoEnd::Aborted(AbortCode::NO_SUCH_OBJECT), |data| {
                    SdoEnd::Value(*data)
                }),
            SdoRequest::Write(address, data) => {
                self.writes.push((address, data.raw()));
                if self.deaf != Some(address) {
                    self.values.insert(address, data);
                }
                if self.mute == Some(address) {
                    self.mute = None;
                    return SdoEnd::TimedOut;
                }
                SdoEnd::Written
            }
            SdoRequest::Abort(..) => panic!("a set-up sends no abort"),
        }
    }

    fn run(
        &mut self,
        options: SetUpOptions,
        steps: &[SetUpStep],
    ) -> Result<SetUpReport, SetUpError> {
        let mut set_up = SetUp::new(options);
        for _ in 0..200 {
            let Some(request) = set_up.wanted(steps) else {
                break;
            };
            let end = self.answer(request);
            set_up.on_end(steps, end);
        }
        set_up.outcome().expect("it ends")
    }
}

const PLAIN: SetUpOptions = SetUpOptions {
    firmware: Firmware::Any,
    save: false,
};

fn speed_on_rpdo1() -> SetUpStep {
    SetUpStep::Pdo(PdoSetUp {
        direction: PdoDirection::Receive,
        number: PdoNumber::Pdo1,
        mapping: PdoMapping::new(&[MappingEntry::of(objects::TARGET_SPEED)]).unwrap(),
        transmission_type: None,
        inhibit_time: None,
        event_timer: None,
    })
}

fn heartbeat(ms: u16) -> SetUpStep {
    SetUpStep::Value(Setting::new(objects::PRODUCER_HEARTBEAT_MS, ms))
}

fn raw_writes(memory: &Memory) -> Vec<(u16, u8, u32)> {
    memory
        .writes
        .iter()
        .map(|(address, raw)| (address.index, address.sub, *raw))
        .collect()
}

#[test]
fn the_mapping_sequence_is_the_printed_one_behind_the_eeprom_guard() {
    let mut memory = Memory::factory();
    let report = memory.run(PLAIN, &[speed_on_rpdo1()]).unwrap();
    // Guide section 6.2, without the save instruction, and with 2010h = 1 first.
    let expected = [
        (0x2010, 0, 1),
        (0x1601, 0, 0),
        (0x1601, 1, 0x60FF_0020),
        (0x1601, 0, 1),
    ];
    assert_eq!(raw_writes(&memory), expected);
    assert_eq!((report.written, report.saved), (4, false));
}

#[test]
fn what_is_right_is_not_written_again() {
    let mut memory = Memory::factory();
    let steps = [heartbeat(100), speed_on_rpdo1()];
    memory.run(PLAIN, &steps).unwrap();
    memory.writes.clear();
    let report = memory.run(PLAIN, &steps).unwrap();
    assert_eq!(raw_writes(&memory), []);
    // The guard, the heartbeat, entry and count.
    assert_eq!(
        report,
        SetUpReport {
            unchanged: 4,
            written: 0,
            saved: false
        }
    );
}

#[test]
fn the_eeprom_is_saved_on_request_and_only_after_a_change() {
    let options = SetUpOptions {
        save: true,
        ..PLAIN
    };
    let mut memory = Memory::factory();
    assert!(memory.run(options, &[heartbeat(100)]).unwrap().saved);
    assert_eq!(raw_writes(&memory).last(), Some(&(0x2009, 0, 2)));
    assert!(!memory.run(options, &[heartbeat(100)]).unwrap().saved);
    // 2010h itself is not stored.
    memory
        .values
        .insert(objects::EEPROM_UPDATE.address(), 0_u16.to_data());
    let report = memory.run(options, &[heartbeat(100)]).unwrap();
    assert_eq!((report.written, report.saved), (1, false));
}

#[test]
fn nothing_is_written_to_an_unknown_drive() {
    let options = SetUpOptions {
        firmware: Firmware::Version(0x21),
        ..PLAIN
    };
    let mut memory = Memory::factory();
    memory
        .values
        .insert(objects::SOFTWARE_VERSION.address(), 0x20_u16.to_data());
    let address = objects::SOFTWARE_VERSION.address();
    let error = SetUpError::Identity {
        address,
        expected: 0x21,
        actual: 0x20,
    };
    assert_eq!(memory.run(options, &[heartbeat(100)]), Err(error));
    // A drive with two axes keeps the number of its speeds here.
    let address = objects::TARGET_SPEED.address();
    memory.values.insert(address, 3_u8.to_data());
    let error = WidthError {
        expected: 4,
        actual: 1,
    };
    assert_eq!(
        memory.run(PLAIN, &[heartbeat(100)]),
        Err(SetUpError::Width { address, error })
    );
    assert_eq!(raw_writes(&memory), []);
}

#[test]
fn a_lost_confirmation_is_answered_by_reading_back() {
    let mut memory = Memory::factory();
    memory.mute = Some(objects::PRODUCER_HEARTBEAT_MS.address());
    assert!(memory.run(PLAIN, &[heartbeat(100)]).is_ok());
    assert_eq!(raw_writes(&memory), [(0x2010, 0, 1), (0x1017, 0, 100)]);
}

#[test]
fn a_write_that_is_not_taken_is_told() {
    let mut memory = Memory::factory();
    let address = objects::PRODUCER_HEARTBEAT_MS.address();
    memory.deaf = Some(address);
    let error = SetUpError::NotTaken {
        address,
        expected: 100,
        actual: 0,
    };
    assert_eq!(memory.run(PLAIN, &[heartbeat(100)]), Err(error));
}

#[test]
fn a_silent_drive_is_asked_three_times() {
    let mut set_up = SetUp::new(PLAIN);
    for _ in 0..3 {
        assert_eq!(set_up.wanted(&[]), Some(objects::DEVICE_TYPE.read()));
        set_up.on_end(&[], SdoEnd::TimedOut);
    }
    let address = objects::DEVICE_TYPE.address();
    assert_eq!(set_up.outcome(), Some(Err(SetUpError::Silent { address })));
}

#[test]
fn what_is_only_expected_is_never_written() {
    let mut memory = Memory::factory();
    let expect = |n| SetUpStep::Expect(Setting::new(objects::SPEED_RESOLUTION, n));
    assert!(memory.run(PLAIN, &[expect(1)]).is_ok());
    let address = objects::SPEED_RESOLUTION.address();
    let error = SetUpError::Differs {
        address,
        expected: 10,
        actual: 1,
    };
    assert_eq!(memory.run(PLAIN, &[expect(10)]), Err(error));
    assert_eq!(raw_writes(&memory), [(0x2010, 0, 1)]);
}

#[test]
fn a_refused_transfer_ends_the_set_up_with_its_reason() {
    let steps = [heartbeat(100)];
    let mut set_up = SetUp::new(PLAIN);
    let request = set_up.wanted(&steps).expect("a first transfer");
    let (address, code) = (request.address(), AbortCode::NO_SUCH_OBJECT);
    set_up.on_end(&steps, SdoEnd::Aborted(code));
    let refused = SetUpError::Refused { address, code };
    assert_eq!(set_up.outcome(), Some(Err(refused)));
    assert_eq!(set_up.wanted(&steps), None);
}

#[test]
fn what_must_be_known_to_be_done_is_not_taken_for_done_without_its_confirmation() {
    // Of an open mapping, and of a save.
    let step = speed_on_rpdo1();
    let gate = step.gate().expect("a mapping is opened first").address();
    let mut memory = Memory::factory();
    memory.mute = Some(gate);
    let silent = |address| Err(SetUpError::Silent { address });
    assert_eq!(memory.run(PLAIN, &[step]), silent(gate));
    let save = SetUpOptions {
        save: true,
        ..PLAIN
    };
    let store = objects::STORE.address();
    let mut memory = Memory::factory();
    memory.mute = Some(store);
    assert_eq!(memory.run(save, &[heartbeat(100)]), silent(store));
}

#[test]
fn a_list_of_too_many_steps_is_refused_before_anything_is_written() {
    let steps = std::vec![heartbeat(100); 300];
    for actual in [255, 256, 300] {
        let mut memory = Memory::factory();
        let error = memory.run(PLAIN, &steps[..actual]);
        assert_eq!(error, Err(SetUpError::TooManySteps { most: 254, actual }));
        assert_eq!(raw_writes(&memory), []);
    }
    let mut set_up = SetUp::new(PLAIN);
    let mut memory = Memory::factory();
    for _ in 0..1_000 {
        let Some(request) = set_up.wanted(&steps[..254]) else {
            break;
        };
        let end = memory.answer(request);
        set_up.on_end(&steps[..254], end);
    }
    let report = set_up.outcome().unwrap().unwrap();
    assert_eq!((report.written, report.unchanged), (2, 253));
}
