//! The page of a report, opened in a browser: its script fills the list of events.

use std::fs;
use std::path::{Path, PathBuf};
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
/// Width in pixels on which the page must be readable, and the least size of the text in its pictures.
const NARROW: u32 = 400;
const LEAST_TEXT: f64 = 10.0;
/// Where the script below leaves what it measured: the width that the page needs, and the size of its smallest text.
const MEASURED: &str = "data-narrow=\"";
/// Makes the page narrow, which no window of a browser can be, and measures it.
const MEASURE: &str = "<script>addEventListener('load',()=>{\
    document.documentElement.style.width='400px';\
    const size=text=>{const svg=text.ownerSVGElement;\
    return parseFloat(getComputedStyle(text).fontSize)*svg.getBoundingClientRect().width/svg.viewBox.baseVal.width};\
    const sizes=[...document.querySelectorAll('svg text')].map(size);\
    document.body.setAttribute('data-narrow',document.querySelector('main').scrollWidth+' '+Math.min(...sizes))})</script>";
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
    check_narrow(place, &folder)?;
    Ok(Vec::new())
}

/// A narrow screen neither cuts the page off nor shrinks its text below what can be read.
fn check_narrow(place: &Place, folder: &Path) -> Result<(), Error> {
    let narrow = folder.join("narrow.html");
    let copied = fs::read_to_string(folder.join("index.html"))
        .map(|page| page.replace("</body>", &format!("{MEASURE}</body>")))
        .and_then(|page| fs::write(&narrow, page));
    copied.map_err(|reason| Error::Start {
        program: narrow.display().to_string(),
        reason,
    })?;
    let dom = dom_of(place, &narrow)?;
    let (width, text) = measured(&dom).ok_or_else(|| Error::Answer {
        program: "the script that measures the page".into(),
        expected: "a width and a size of text",
    })?;
    println!("on {NARROW} pixels: the page needs {width}, its smallest text has {text:.1}");
    if width > f64::from(NARROW) || text < LEAST_TEXT {
        return Err(Error::Answer {
            program: "the page on 400 pixels".into(),
            expected: "nothing beyond 400 pixels, and text of at least 10",
        });
    }
    Ok(())
}

fn measured(dom: &str) -> Option<(f64, f64)> {
    let answer = dom.split(MEASURED).nth(1)?.split('"').next()?;
    let (width, text) = answer.split_once(' ')?;
    Some((width.parse().ok()?, text.parse().ok()?))
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

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_the_page_measured_is_read() {
        let dom = format!("<body {MEASURED}400 10.5\"><main>");
        assert_eq!(measured(&dom), Some((400.0, 10.5)));
        assert_eq!(measured("<body>"), None);
    }
}
