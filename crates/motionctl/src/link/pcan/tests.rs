use std::process::Command;
use std::sync::{Mutex, OnceLock};

use super::*;

/// The library of the tests of `pcan-basic`.
const SOURCE: &str = concat!(
    env!("CARGO_MANIFEST_DIR"),
    "/../pcan-basic/tests/fake/pcan_basic.c"
);

/// The library has one state, as its adapters have.
static ADAPTERS: Mutex<()> = Mutex::new(());

fn open(name: &str, channel: Channel) -> Result<Pcan, OpenError> {
    static FOLDER: OnceLock<tempfile::TempDir> = OnceLock::new();
    let folder = FOLDER.get_or_init(|| {
        let folder = tempfile::tempdir().unwrap();
        let file = folder.path().join("library");
        let mut compiler = Command::new("cc");
        compiler
            .args(["-shared", "-fPIC", "-o"])
            .arg(file)
            .arg(SOURCE);
        assert!(compiler.status().unwrap().success());
        folder
    });
    let load = || PcanBasic::load_from(folder.path().join("library"));
    Pcan::open_with(load, name, 1_000, channel)
}

fn set_point() -> Frame {
    Frame::new(StandardId::new(0x03C).unwrap(), &[0x0A, 0x28]).unwrap()
}

#[test]
fn frames_cross_it_both_ways() {
    let _turn = ADAPTERS.lock();
    let mut pcan = open("PCAN_USBBUS1", Channel::Open).unwrap();
    assert_eq!(pcan.receive(), Err(nb::Error::WouldBlock));
    assert_eq!(pcan.transmit(&set_point()), Ok(None));
    let remote = Frame::new_remote(ExtendedId::new(0x1FFF_FFFE).unwrap(), 3).unwrap();
    assert_eq!(pcan.transmit(&remote), Ok(None));
    pcan.wait(Duration::from_secs(1));
    let answer = Frame::new(StandardId::new(0x03D).unwrap(), &[0x0A, 0x28]).unwrap();
    assert_eq!(pcan.receive(), Ok(answer));
    let answer = Frame::new_remote(ExtendedId::new(0x1FFF_FFFF).unwrap(), 3).unwrap();
    assert_eq!(pcan.receive(), Ok(answer));
    assert_eq!(pcan.receive(), Err(nb::Error::WouldBlock));
    assert_eq!(pcan.fault(), None);
}

#[test]
fn nothing_is_queued_in_an_adapter_that_gets_nothing_through() {
    let _turn = ADAPTERS.lock();
    for name in ["PCAN_USBBUS6", "PCAN_USBBUS8"] {
        let mut pcan = open(name, Channel::Open).unwrap();
        let mut taken = 0;
        while taken < 10 && pcan.transmit(&set_point()).is_ok() {
            taken += 1;
        }
        // The first has room for one frame, the second is error passive.
        assert_eq!(taken, u32::from(name == "PCAN_USBBUS6"), "{name}");
        assert_eq!(pcan.transmit(&set_point()), Err(nb::Error::WouldBlock));
        assert_eq!(pcan.fault(), None);
    }
}

#[test]
fn bus_off_and_an_adapter_that_is_unplugged_are_final() {
    let _turn = ADAPTERS.lock();
    for (name, fault) in [
        ("PCAN_USBBUS5", LinkFault::BusOff),
        ("PCAN_USBBUS7", LinkFault::Vanished),
    ] {
        let mut pcan = open(name, Channel::Open).unwrap();
        assert_eq!(pcan.transmit(&set_point()), Ok(None));
        // Nothing says so but the status, which is asked for while nothing comes.
        pcan.wait(Duration::from_secs(1));
        assert_eq!(pcan.fault(), Some(fault));
        assert_eq!(pcan.transmit(&set_point()), Err(nb::Error::Other(fault)));
        assert_eq!(pcan.receive(), Err(nb::Error::Other(fault)));
    }
}

#[test]
fn frames_that_were_lost_are_told_and_the_link_goes_on() {
    let _turn = ADAPTERS.lock();
    let mut pcan = open("PCAN_USBBUS11", Channel::Open).unwrap();
    let overrun = LinkFault::Bus(ErrorKind::Overrun);
    assert_eq!(pcan.receive(), Err(nb::Error::Other(overrun)));
    assert_eq!(pcan.receive(), Err(nb::Error::WouldBlock));
    assert_eq!(pcan.fault(), None);
}

#[test]
fn what_is_wrong_is_told_with_the_channel() {
    let _turn = ADAPTERS.lock();
    let refused = |name, channel| open(name, channel).unwrap_err().to_string();
    let message = refused("PCAN_USBBUS3", Channel::Open);
    assert!(
        message.starts_with("cannot open pcan:PCAN_USBBUS3: PCAN_USBBUS3 is in use"),
        "{message}"
    );
    let message = refused("PCAN_USBBUS10", Channel::ListenOnly);
    assert!(
        message.contains("cannot listen without acknowledging"),
        "{message}"
    );
    let message = refused("COM3", Channel::Open);
    assert_eq!(
        message,
        "pcan: expected PCAN_USBBUS1 to PCAN_USBBUS16, got COM3"
    );
}

#[test]
fn elsewhere_than_on_windows_the_way_is_told() {
    let message = Pcan::open("PCAN_USBBUS1", 1_000, Channel::Open)
        .unwrap_err()
        .to_string();
    assert!(
        message.contains("--can can0") && message.contains("ip link set can0 up type can bitrate"),
        "{message}"
    );
}
