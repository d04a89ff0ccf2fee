//! Settings of a hub motor, as steps of a set-up, on the simulated drive: what they do, and what they cost the EEPROM.

use drive_sim::{
    Bench, BitRate, ControllerConfig, DeviceId, Frame, NodeId as BusNode, ZlacDrive,
    ZlacDriveConfig,
};
use embedded_can::nb::Can;
use zlac8030l::{
    DataFrame, Firmware, NodeId, SdoClient, SdoHeard, SdoTimeouts, SetUp, SetUpError, SetUpOptions,
    SetUpReport, SetUpStep, objects, settings,
};

const MS: u64 = 1_000_000;

struct Rig {
    bench: Bench<ZlacDrive>,
    master: BusNode,
    drive: DeviceId,
}

impl Rig {
    fn new() -> Self {
        let config = ZlacDriveConfig {
            bus_bit_rate: Some(BitRate::Kbit500),
            ..ZlacDriveConfig::new(NodeId::FACTORY)
        };
        let (mut bench, drives) = Bench::with_zlac_drives(BitRate::Kbit500, [config]);
        let master = bench.add_master(ControllerConfig::device());
        bench.advance_to(200 * MS);
        Self {
            bench,
            master,
            drive: drives[0],
        }
    }

    fn drive(&self) -> &ZlacDrive {
        self.bench.device(self.drive)
    }

    fn send(&mut self, frame: &DataFrame) {
        let frame: Frame = frame.to_can().expect("a frame");
        self.bench.port(self.master).transmit(&frame).expect("room");
    }

    /// Runs a set-up to its end.
    fn set_up(&mut self, steps: &[SetUpStep], save: bool) -> Result<SetUpReport, SetUpError> {
        let node = NodeId::new(self.drive().node_id().into()).expect("a node");
        let mut script = SetUp::new(SetUpOptions {
            firmware: Firmware::Any,
            save,
        });
        let mut client = SdoClient::new(node, SdoTimeouts::DEFAULT);
        loop {
            if let Some(outcome) = script.outcome() {
                return outcome;
            }
            let now_us = self.bench.now_ns() / 1_000;
            if let Some(request) = script.wanted(steps)
                && let Ok(frame) = client.start(now_us, request)
            {
                self.send(&frame);
            }
            self.bench.advance_to(self.bench.now_ns() + MS);
            while let Ok(frame) = self.bench.port(self.master).receive() {
                let frame = DataFrame::from_can(&frame).expect("a data frame");
                let now_us = self.bench.now_ns() / 1_000;
                if let SdoHeard::Ended(event) = client.on_frame(now_us, &frame) {
                    script.on_end(steps, event.end);
                }
            }
            if let Some(event) = client.poll(self.bench.now_ns() / 1_000) {
                script.on_end(steps, event.end);
            }
        }
    }

    fn value(&self, object: zlac8030l::ObjectAddress) -> u32 {
        self.drive().object(self.bench.now_ns(), object)
    }

    fn power_cycle(&mut self) {
        let faults = self.bench.device_mut(self.drive).faults_mut();
        faults.power_cycle(100 * MS);
        self.bench.advance_to(self.bench.now_ns() + 500 * MS);
        while self.bench.port(self.master).receive().is_ok() {}
    }
}

#[test]
fn settings_are_saved_in_one_write_and_last() {
    let steps = [
        &settings::parking(true)[..],
        &settings::alarm_pwm(true),
        &settings::emergency_inputs(false, true, true),
        &settings::speed_resolution(10).expect("a divider"),
    ]
    .concat();
    let mut rig = Rig::new();
    let report = rig.set_up(&steps, true).expect("it ends well");
    assert!(report.saved);
    rig.power_cycle();
    let values = [
        objects::PARKING.address(),
        objects::ALARM_PWM.address(),
        objects::EMERGENCY_INPUT_RELEASES.address(),
        objects::INPUT_X0.address(),
        objects::INPUT_X1.address(),
        objects::SPEED_RESOLUTION.address(),
    ]
    .map(|object| rig.value(object));
    assert_eq!(values, [1, 1, 1, 0, 9, 10]);
    let wear = rig.drive().eeprom_wear();
    assert_eq!((wear.single_writes, wear.saves), (0, 1));
    // Nothing differs any more.
    let report = rig.set_up(&steps, true).expect("it ends well");
    assert!(!report.saved);
    assert_eq!(rig.drive().eeprom_wear().saves, 1);
}

#[test]
fn without_a_save_a_power_cycle_undoes_everything() {
    let mut rig = Rig::new();
    rig.set_up(&settings::parking(true), false)
        .expect("it ends well");
    assert_eq!(rig.value(objects::PARKING.address()), 1);
    rig.power_cycle();
    assert_eq!(rig.value(objects::PARKING.address()), 0);
    assert_eq!(rig.drive().eeprom_wear(), Default::default());
}

#[test]
fn a_brake_closes_and_is_open_again_after_a_start() {
    let mut rig = Rig::new();
    rig.set_up(&settings::holding_brake(true), true)
        .expect("it ends well");
    // Bit 2 of the outputs is B0.
    assert_eq!(rig.value(zlac8030l::ObjectAddress::new(0x2004, 0)), 0b100);
    rig.power_cycle();
    assert_eq!(rig.value(objects::HOLDING_BRAKE.address()), 0);
    assert_eq!(rig.drive().eeprom_wear(), Default::default());
}

#[test]
fn a_node_and_a_bit_rate_are_stored_for_the_next_start() {
    let node = |number| NodeId::new(number).expect("a node");
    let mut rig = Rig::new();
    let steps = settings::node(node(9)).expect("it can be stored");
    rig.set_up(&steps, true).expect("it ends well");
    assert_eq!(rig.drive().node_id(), 4);
    rig.power_cycle();
    assert_eq!(rig.drive().node_id(), 9);
    let steps = settings::bit_rate(BitRate::Kbit250).expect("the drive has it");
    rig.set_up(&steps, true).expect("it ends well");
    rig.power_cycle();
    // It is on another bit rate, and gone from this bus.
    let silent = rig.set_up(&settings::parking(true), false);
    assert!(
        matches!(silent, Err(SetUpError::Silent { .. })),
        "{silent:?}"
    );
    assert_eq!(settings::node(node(3)), None);
    assert_eq!(settings::bit_rate(BitRate::Kbit800), None);
    assert_eq!(settings::speed_resolution(0), None);
    assert_eq!(settings::speed_resolution(11), None);
}
