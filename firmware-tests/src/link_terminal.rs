//! The emulated board in real time, its serial port on a pseudo-terminal: what a host program opens in the place of the board's port.

use std::io::{self, BufRead as _};
use std::path::Path;
use std::sync::mpsc::{self, Receiver};
use std::thread;
use std::time::{Duration, Instant};

use firmware_tests::host::{BIT_RATE, Host};
use firmware_tests::orders::set_up;
use firmware_tests::{Contact, ResetCause, Rig, Stop};

use crate::mechanics::MechanicsOptions;
use crate::pseudo_terminal::Pty;

/// The emulator looks at the clock this often.
const STEP: Duration = Duration::from_millis(1);
/// It says once how far behind real time it is, from here on.
const BEHIND: Duration = Duration::from_secs(1);

/// What a line of the standard input asks for.
const HELP: &str = "stop|enable open|close, or reset";

/// Writes settings over the serial port and starts the board anew, before the terminal is there.
pub(crate) fn write_settings(rig: &mut Rig, path: &Path) -> Result<(), String> {
    let told = |error: &dyn std::fmt::Display| format!("{}: {error}", path.display());
    let text = std::fs::read_to_string(path).map_err(|error| told(&error))?;
    let settings = board_settings::file::read(&text).map_err(|error| told(&error))?;
    let mut host = Host::new(rig, 1);
    set_up(rig, &mut host, &settings.settings);
    Ok(())
}

/// Runs the board until `ms` of its time have passed, or for ever.
pub(crate) fn run(
    rig: &mut Rig,
    link: &Path,
    (ms, mechanics): (Option<u64>, &MechanicsOptions),
) -> Result<(), String> {
    let terminal = Pty::create(link).map_err(|error| format!("{}: {error}", link.display()))?;
    println!("--- the serial port of the board is {terminal}; standard input: {HELP}");
    rig.serial_mut().set_rate(BIT_RATE);
    for contact in [Contact::Stop, Contact::Enable] {
        println!("--- {contact:?} is closed");
        rig.close(contact);
    }
    let lines = lines();
    let (begun, mut printed, mut is_told) = (Instant::now(), 0, false);
    let (mut passed, mut waiting, mut buffer) = (Duration::ZERO, Vec::new(), [0; 4_096]);
    while ms.is_none_or(|ms| passed < Duration::from_millis(ms)) {
        let told = |error: io::Error| format!("{terminal}: {error}");
        let bytes = terminal.read(&mut buffer).map_err(told)?;
        rig.send_serial(bytes);
        for line in lines.try_iter() {
            obey(rig, line.trim());
        }
        mechanics.connect(rig);
        let stop = rig.run_ms(1);
        if stop != Stop::Limit {
            return Err(format!("the processor stopped: {stop:x?}"));
        }
        waiting.extend(rig.received_serial());
        let written = terminal.write(&waiting).map_err(told)?;
        waiting.drain(..written);
        printed = print_log(rig, printed);
        passed += STEP;
        let real = begun.elapsed();
        thread::sleep(passed.saturating_sub(real));
        if !is_told && real.saturating_sub(passed) > BEHIND {
            is_told = true;
            eprintln!(
                "warning: this computer is slower than the board; its time passes slower than real time"
            );
        }
    }
    Ok(())
}

fn lines() -> Receiver<String> {
    let (sender, receiver) = mpsc::channel();
    thread::spawn(move || {
        for line in io::stdin().lock().lines().map_while(Result::ok) {
            if sender.send(line).is_err() {
                return;
            }
        }
    });
    receiver
}

fn obey(rig: &mut Rig, line: &str) {
    match line {
        "stop open" => rig.open(Contact::Stop),
        "stop close" => rig.close(Contact::Stop),
        "enable open" => rig.open(Contact::Enable),
        "enable close" => rig.close(Contact::Enable),
        "reset" => rig.board_mut().restart(ResetCause::Pin),
        "" => return,
        other => return eprintln!("error: `{other}` is none of: {HELP}"),
    }
    println!("--- {line}");
}

/// Prints what the board has written to its log since; a reset begins it anew.
fn print_log(rig: &Rig, printed: usize) -> usize {
    let log = rig.board().log();
    for line in log.get(printed..).unwrap_or(log) {
        println!("{line}");
    }
    log.len()
}
