//! Channels of a library that behaves as PCAN-Basic is described: each number has its own trouble, see `fake/pcan_basic.c`.

// Elsewhere the compiler of C, and the library without the functions, have other names.
#![cfg(target_os = "linux")]

mod fake;

use std::sync::{Mutex, OnceLock};

use pcan_basic::{Channel, Error, Message, Mode, PcanBasic, Status};

/// The library has one state, as its adapters have.
static ADAPTERS: Mutex<()> = Mutex::new(());

fn open(number: u8, kbit_per_s: u32, mode: Mode) -> Result<Channel, Error> {
    // A library that is loaded anew would have forgotten which channels are open.
    static KEPT: OnceLock<PcanBasic> = OnceLock::new();
    KEPT.get_or_init(|| PcanBasic::load_from(fake::library()).unwrap());
    let name = format!("PCAN_USBBUS{number}").parse().unwrap();
    Channel::open(
        PcanBasic::load_from(fake::library())?,
        name,
        kbit_per_s,
        mode,
    )
}

fn frame(id: u32) -> Message {
    Message::new(id, false, &[1, 2, 0xFF]).unwrap()
}

#[test]
fn frames_cross_a_channel_unchanged_and_what_the_adapter_tells_of_itself_is_no_frame() {
    let _turn = ADAPTERS.lock();
    let channel = open(1, 1_000, Mode::Normal).unwrap();
    assert_eq!(channel.status(), None);
    assert_eq!(channel.read(), Ok(None));
    channel.write(&frame(0x123)).unwrap();
    let extended = Message::new(0x1234_5678, true, &[]).unwrap();
    channel.write(&extended).unwrap();
    let remote = Message::new_remote(0x7FE, false, 8).unwrap();
    channel.write(&remote).unwrap();
    assert_eq!(channel.read(), Ok(Some(frame(0x124))));
    assert_eq!(channel.read(), Ok(Message::new(0x1234_5679, true, &[])));
    assert_eq!(channel.read(), Ok(Message::new_remote(0x7FF, false, 8)));
    assert_eq!(channel.read(), Ok(None));
    // ILLPARAMVAL: an identifier of more than 11 bits.
    assert_eq!(channel.write(&frame(0x800)), Err(Status(0x8000)));
}

#[test]
fn a_channel_is_closed_with_its_value() {
    let _turn = ADAPTERS.lock();
    let first = open(1, 1_000, Mode::Normal).unwrap();
    assert!(matches!(
        open(1, 1_000, Mode::Normal),
        Err(Error::Busy { .. })
    ));
    drop(first);
    assert!(open(1, 250, Mode::Normal).is_ok());
}

#[test]
fn each_reason_not_to_open_has_its_own_message() {
    let _turn = ADAPTERS.lock();
    let refusal =
        |number, kbit_per_s, mode| open(number, kbit_per_s, mode).unwrap_err().to_string();
    for (number, expected) in [
        (2, "there is no adapter at PCAN_USBBUS2"),
        (3, "PCAN_USBBUS3 is in use by another program"),
        (9, "the driver of the PCAN adapters is not loaded"),
        (12, "The error is not known (PCAN-Basic status 10000h)"),
    ] {
        let message = refusal(number, 1_000, Mode::Normal);
        assert!(message.starts_with(expected), "{message}");
    }
    let message = refusal(4, 1_000, Mode::Normal);
    assert!(
        message
            .starts_with("PCAN_USBBUS4 runs at another bit rate than 1000 kbit/s, at 500 kbit/s:"),
        "{message}"
    );
    // It was given back.
    assert!(open(4, 500, Mode::Normal).is_ok());
    let message = refusal(1, 333, Mode::Normal);
    assert!(message.ends_with("got 333"), "{message}");
}

#[test]
fn a_channel_that_listens_sends_nothing_and_one_that_cannot_listen_is_not_opened() {
    let _turn = ADAPTERS.lock();
    let channel = open(1, 1_000, Mode::ListenOnly).unwrap();
    assert!(channel.write(&frame(1)).is_err());
    drop(channel);
    let channel = open(1, 1_000, Mode::Normal).unwrap();
    assert_eq!(channel.write(&frame(1)), Ok(()));
    let refused = open(10, 1_000, Mode::ListenOnly);
    assert!(
        matches!(refused, Err(Error::NoListenOnly { .. })),
        "{refused:?}"
    );
    assert!(open(10, 1_000, Mode::Normal).is_ok());
}

#[test]
fn a_bus_or_an_adapter_in_trouble_says_so() {
    let _turn = ADAPTERS.lock();
    let channel = |number| open(number, 1_000, Mode::Normal).unwrap();
    let (off, full, unplugged, passive, slow) =
        (channel(5), channel(6), channel(7), channel(8), channel(11));
    for channel in [&off, &full, &unplugged] {
        assert_eq!(channel.write(&frame(1)), Ok(()));
    }
    assert!(off.status().is_some_and(Status::is_bus_off));
    assert!(full.write(&frame(1)).is_err_and(Status::is_full));
    assert!(unplugged.status().is_some_and(Status::is_lost));
    assert!(
        passive
            .status()
            .is_some_and(|status| status.is_passive() && !status.is_lost())
    );
    assert!(slow.read().is_err_and(Status::is_overrun));
    assert_eq!(slow.read(), Ok(None));
}

#[test]
fn a_missing_library_and_one_without_the_functions_are_told_apart() {
    let missing = PcanBasic::load_from("no-such-folder/PCANBasic.dll").unwrap_err();
    let message = missing.to_string();
    assert!(
        message.starts_with("there is no no-such-folder/PCANBasic.dll (")
            && message.contains("peak-system.com"),
        "{message}"
    );
    let other = PcanBasic::load_from("libc.so.6").unwrap_err();
    assert!(
        matches!(
            other,
            Error::NoFunction {
                function: "CAN_Initialize",
                ..
            }
        ),
        "{other:?}"
    );
}
