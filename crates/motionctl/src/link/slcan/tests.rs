use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::{Arc, Mutex};

use embedded_can::{Frame as _, StandardId};

use super::super::fake_adapter::{FakeAdapter, SETTINGS, set_up_answer};
use super::*;

fn open(adapter: &FakeAdapter) -> Result<Slcan, OpenError> {
    Slcan::open(adapter.port(), SETTINGS, Channel::Open)
}

fn frame(byte: u8) -> Frame {
    Frame::new(StandardId::new(0x03C).unwrap(), &[byte]).unwrap()
}

/// Hands a frame over as soon as there is room for it.
fn transmit(slcan: &mut Slcan, frame: &Frame) -> Option<Frame> {
    loop {
        match slcan.transmit(frame) {
            Ok(back) => return back,
            Err(nb::Error::WouldBlock) => slcan.wait(Duration::from_millis(1)),
            Err(error) => panic!("{error:?}"),
        }
    }
}

/// What an adapter was told while `use_it` ran.
fn told(
    name: &str,
    answer: impl Fn(&[u8]) -> Vec<u8> + Send + 'static,
    use_it: impl FnOnce(Result<Slcan, OpenError>),
) -> Vec<String> {
    let lines = Arc::new(Mutex::new(Vec::new()));
    let log = Arc::clone(&lines);
    let mut adapter = FakeAdapter::new(name, move |line| {
        let text = String::from_utf8(line.to_vec()).unwrap();
        log.lock().unwrap().push(text);
        answer(line)
    });
    use_it(open(&adapter));
    // What is on its way arrives before the adapter is taken away.
    std::thread::sleep(Duration::from_millis(50));
    adapter.vanish();
    lines.lock().unwrap().clone()
}

#[test]
fn a_refused_frame_comes_back_from_a_later_transmit() {
    let adapter = FakeAdapter::new("refuse", |line| match line {
        b"t03C102" => b"\x07".to_vec(),
        b"t03C1FF" => b"z\rt03D1EE\r".to_vec(),
        [b't', ..] => b"z\r".to_vec(),
        line => set_up_answer(line),
    });
    let mut slcan = open(&adapter).unwrap();
    let mut back = Vec::new();
    for byte in [1, 2, 3, 4, 5, 0xFF] {
        back.extend(transmit(&mut slcan, &frame(byte)));
        // Until its answer is there.
        for _ in 0..4 {
            slcan.wait(Duration::from_millis(5));
        }
    }
    assert_eq!(back, [frame(2)]);
    while slcan.received.is_empty() {
        slcan.wait(Duration::from_millis(5));
    }
    let alarm = Frame::new(StandardId::new(0x03D).unwrap(), &[0xEE]).unwrap();
    assert_eq!(slcan.receive(), Ok(alarm));
    assert_eq!(slcan.receive(), Err(nb::Error::WouldBlock));
    assert_eq!(slcan.take_unknown(), 0);
}

#[test]
fn no_opening_sends_an_empty_line_or_anything_twice_that_acts() {
    for answers in [true, false] {
        let heard = told(
            &format!("lines-{answers}"),
            move |line| match line {
                _ if answers => set_up_answer(line),
                b"V" => b"1a2b3c4 somebody/slcan\r".to_vec(),
                _ => Vec::new(),
            },
            |slcan| drop(slcan.unwrap()),
        );
        assert!(heard.iter().all(|line| !line.is_empty()), "{heard:?}");
        let frames = heard
            .iter()
            .filter(|line| line.starts_with(['t', 'T', 'r', 'R']));
        assert_eq!(frames.count(), 0, "{heard:?}");
        let count = |letter| heard.iter().filter(|line| *line == letter).count();
        assert_eq!(count("O"), 1, "{heard:?}");
        // The channel is closed before the bit rate is set, and at the end.
        assert_eq!(heard.last().map(String::as_str), Some("C"), "{heard:?}");
        assert!(heard[0].len() > 138, "longer than any command: {heard:?}");
        assert!(heard[0].bytes().all(|byte| !byte.is_ascii_hexdigit()));
    }
}

#[test]
fn an_adapter_that_takes_one_command_a_packet_gets_one_at_a_time() {
    // It answers the second of two commands only when it came alone.
    let adapter = FakeAdapter::one_command_a_packet("one-a-packet", |line| match line {
        [b't', ..] => b"z\r".to_vec(),
        line => set_up_answer(line),
    });
    let mut slcan = open(&adapter).unwrap();
    // The second command of the question, and of those that a slow answer made the tool repeat.
    let of_questions = adapter.dropped();
    assert!(of_questions > 0);
    assert_eq!(slcan.transmit(&frame(1)), Ok(None));
    for byte in 2..50 {
        assert_eq!(transmit(&mut slcan, &frame(byte)), None);
    }
    drop(slcan);
    assert_eq!(adapter.dropped(), of_questions, "no frame");
}

#[test]
fn letters_that_lost_their_end_are_still_answers() {
    let adapter = FakeAdapter::new("no-end", |line| match line {
        b"t03C101" => b"z".to_vec(),
        b"t03C102" => b"zt02910000000BB8\r".to_vec(),
        line => set_up_answer(line),
    });
    let mut slcan = open(&adapter).unwrap();
    assert_eq!(slcan.transmit(&frame(1)), Ok(None));
    assert_eq!(slcan.transmit(&frame(2)), Ok(None));
    while slcan.received.is_empty() {
        slcan.wait(Duration::from_millis(5));
    }
    let status = Frame::new(StandardId::new(0x029).unwrap(), &[0]).unwrap();
    assert_eq!(slcan.receive(), Ok(status));
    std::thread::sleep(ANSWER_LIMIT);
    slcan.wait(Duration::ZERO);
    assert_eq!((slcan.take_unknown(), slcan.is_silent()), (0, false));
}

#[test]
fn an_adapter_that_is_gone_is_a_final_fault() {
    let mut adapter = FakeAdapter::new("gone", set_up_answer);
    let mut slcan = open(&adapter).unwrap();
    adapter.vanish();
    while slcan.fault().is_none() {
        slcan.wait(Duration::from_millis(5));
    }
    assert_eq!(slcan.fault(), Some(LinkFault::Vanished));
    let gone = || nb::Error::Other(LinkFault::Vanished);
    assert_eq!(slcan.transmit(&frame(1)), Err(gone()));
    assert_eq!(slcan.receive(), Err(gone()));
}

#[test]
fn what_does_not_answer_as_an_adapter_is_told() {
    let modem = FakeAdapter::new("modem", |_| b"ERROR\r".to_vec());
    let Err(error @ OpenError::NoAdapter { .. }) = open(&modem) else {
        panic!("a modem is no adapter");
    };
    assert!(error.to_string().contains("said \"ERROR\""), "{error}");
    let echo = FakeAdapter::new("echo", |line| [line, b"\r"].concat());
    assert!(matches!(open(&echo), Err(OpenError::NoAdapter { .. })));
    let narrow = FakeAdapter::new("narrow", |line| match line {
        b"S8" => b"\x07".to_vec(),
        line => set_up_answer(line),
    });
    let refused = open(&narrow).unwrap_err();
    assert!(
        refused.to_string().contains("answers BEL to S8"),
        "{refused}"
    );
    let odd = Settings {
        kbit_per_s: 333,
        ..SETTINGS
    };
    let odd = Slcan::open(narrow.port(), odd, Channel::Open);
    assert!(matches!(odd, Err(OpenError::BitRate { kbit_per_s: 333 })));
    let deaf = FakeAdapter::new("deaf", |line| match line {
        b"L" => b"\x07".to_vec(),
        line => set_up_answer(line),
    });
    let refused = Slcan::open(deaf.port(), SETTINGS, Channel::ListenOnly).unwrap_err();
    assert!(refused.to_string().contains("--acknowledge"), "{refused}");
}

#[test]
fn an_adapter_that_answers_nothing_must_be_meant() {
    let silent = FakeAdapter::new("nothing", |_| Vec::new());
    let error = open(&silent).unwrap_err().to_string();
    assert!(error.contains("--no-answers"), "{error}");
    let meant = Settings {
        expects_answers: false,
        ..SETTINGS
    };
    let mut slcan = Slcan::open(silent.port(), meant, Channel::Open).unwrap();
    assert_eq!(slcan.transmit(&frame(1)), Ok(None));
}

#[test]
fn an_empty_line_is_an_answer_too() {
    let adapter = FakeAdapter::new("bare", |line| match line {
        [b't', ..] => b"\r".to_vec(),
        line => set_up_answer(line),
    });
    let mut slcan = open(&adapter).unwrap();
    assert_eq!(slcan.transmit(&frame(1)), Ok(None));
    std::thread::sleep(ANSWER_LIMIT);
    slcan.wait(Duration::ZERO);
    assert_eq!((slcan.take_unknown(), slcan.is_silent()), (0, false));
}

#[test]
fn what_a_full_port_does_not_take_is_not_sent_later() {
    let is_stuck = Arc::new(AtomicBool::new(true));
    let heard = Arc::new(Mutex::new(Vec::new()));
    let (stuck, log) = (Arc::clone(&is_stuck), Arc::clone(&heard));
    let adapter = FakeAdapter::new("full", move |line| match line {
        [b't', ..] => {
            log.lock().unwrap().push(line.to_vec());
            while stuck.load(Ordering::Relaxed) {
                std::thread::sleep(Duration::from_millis(1));
            }
            Vec::new()
        }
        line => set_up_answer(line),
    });
    let mut slcan = open(&adapter).unwrap();
    let mut sent = 0_usize;
    let mut refused = 0;
    // Ten bytes with its end: the port takes a part of one in the end.
    let two_bytes = Frame::new(StandardId::new(0x03C).unwrap(), &[1, 1]).unwrap();
    // After the first ones it is known that it answers for no frame, and then only the port is a limit.
    for _ in 0..100_000 {
        match slcan.transmit(&two_bytes) {
            Ok(_) => sent += 1,
            Err(nb::Error::WouldBlock) if refused > 5 => break,
            Err(nb::Error::WouldBlock) if slcan.is_silent() => refused += 1,
            Err(nb::Error::WouldBlock) => slcan.wait(Duration::from_millis(5)),
            Err(error) => panic!("{error:?}"),
        }
    }
    assert!((100..100_000).contains(&sent), "{sent} frames fill a port");
    is_stuck.store(false, Ordering::Relaxed);
    while heard.lock().unwrap().len() < sent {
        // The rest of a frame of which a part was taken goes out with the next one.
        slcan.write_out();
        std::thread::sleep(Duration::from_millis(1));
    }
    assert_eq!(slcan.transmit(&frame(2)), Ok(None));
    while heard.lock().unwrap().last().map(Vec::as_slice) != Some(b"t03C102") {
        std::thread::sleep(Duration::from_millis(1));
    }
    let heard = heard.lock().unwrap();
    assert!(
        heard[..sent].iter().all(|line| line == b"t03C20101"),
        "{heard:?}"
    );
    assert_eq!(heard.len(), sent + 1);
}

#[test]
fn what_an_earlier_user_was_sent_is_no_answer() {
    let adapter = FakeAdapter::new("earlier", |line| match line {
        // On its way when the channel is closed.
        b"C" => b"t029155\r\r".to_vec(),
        line => set_up_answer(line),
    });
    let mut slcan = open(&adapter).unwrap();
    slcan.wait(Duration::from_millis(20));
    assert_eq!(slcan.receive(), Err(nb::Error::WouldBlock));
}
