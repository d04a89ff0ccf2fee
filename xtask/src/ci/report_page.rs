//! The page of a report, opened in a browser: its script fills the list of events.

use std::fs;
use std::path::PathBuf;
use std::process::Stdio;

use super::need::{BROWSERS, is_installed};
use super::place::Place;
use crate::error::Error;

/// A motion with faults: the tool ends with 1, because a drive reports an alarm.
const SIMULATION: &str =
    "run -q --profile tools -p motionctl -- sim --faults examples/faults.toml --report";
const WITH_FAULTS: i32 = 1;
/// What the script writes for the fourth event.
const FOURTH_EVENT: &str = "<option value=\"3\">";
const EVENT: &str = "<option value=";
/// No window, no network, and nothing of the user's own profile.
const OPTIONS: [&str; 7] = [
    "--headless",
    "--no-sandbox",
    "--disable-gpu",
    "--disable-background-networking",
    "--disable-component-update",
    "--disable-sync",
    "--dump-dom",
];

/// Makes a report and lets the browser run its script.
///
/// # Errors
/// When the report or the browser fails, or the page has no events.
pub(super) fn run(place: &Place) -> Result<Vec<String>, Error> {
    let folder = place.target().join("report");
    simulate(place, &folder)?;
    let dom = dom_of(place, &folder.join("index.html"))?;
    if !dom.contains(FOURTH_EVENT) {
        return Err(Error::Answer {
            program: "the script of the report".into(),
            expected: "a list with at least four events",
        });
    }
    println!(
        "the script ran: {} events to go to",
        dom.matches(EVENT).count()
    );
    Ok(Vec::new())
}

fn simulate(place: &Place, folder: &PathBuf) -> Result<(), Error> {
    let program = "motionctl sim --report";
    let status = place
        .command(crate::workspace::cargo())
        .args(SIMULATION.split(' '))
        .arg(folder)
        .stdout(Stdio::null())
        .status()
        .map_err(|reason| Error::Start {
            program: program.into(),
            reason,
        })?;
    if status.success() || status.code() == Some(WITH_FAULTS) {
        return Ok(());
    }
    Err(Error::Failed {
        program: program.into(),
        status,
    })
}

/// The page after its script ran.
fn dom_of(place: &Place, page: &PathBuf) -> Result<String, Error> {
    let browser = BROWSERS
        .into_iter()
        .find(|browser| is_installed(browser))
        .unwrap_or(BROWSERS[0]);
    let profile = place.target().join("report-browser");
    let output = place
        .command(browser)
        .args(OPTIONS)
        .arg(format!("--user-data-dir={}", profile.display()))
        .arg(page)
        .output()
        .map_err(|reason| Error::Start {
            program: browser.into(),
            reason,
        })?;
    // A profile that stays costs only space.
    let _ = fs::remove_dir_all(profile);
    if !output.status.success() {
        eprint!("{}", String::from_utf8_lossy(&output.stderr));
        return Err(Error::Failed {
            program: browser.into(),
            status: output.status,
        });
    }
    Ok(String::from_utf8_lossy(&output.stdout).into_owned())
}
