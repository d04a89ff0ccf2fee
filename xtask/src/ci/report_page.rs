//! The pages of simulations, of a run on a bench and of its log, opened in a browser on a wide and on a narrow screen, light and dark.

use std::fs;
use std::path::{Path, PathBuf};
use std::process::{Child, Command, Stdio};
use std::time::{Duration, Instant};

use super::need::{BROWSERS, is_installed};
use super::place::Place;
use crate::error::Error;

/// Simulations and what their pages are called. In the first one a drive reports an alarm, so the tool ends with 1.
const SIMULATIONS: [(&str, &[&str]); 3] = [
    ("sim", &["--faults", "examples/faults.toml"]),
    ("wheels", &["--drives", "zlac"]),
    (
        "program",
        &[
            "--program",
            "examples/programs/square.ngc",
            "--axes",
            "2",
            "--mm-per-turn",
            "20",
        ],
    ),
];
const WITH_FAULTS: i32 = 1;
/// The bench comes up within this.
const PATIENCE: Duration = Duration::from_secs(30);

/// Measures the page in which it stands.
const MEASURE: &str = include_str!("report_page/measure.js");
/// Makes the page narrow, which no window of a browser can be.
const FRAME: &str = include_str!("report_page/frame.html");
/// Where the script leaves what it measured.
const MEASURED: &str = "data-measured=\"";
/// Widths in pixels, and what the reader prefers.
const SCREENS: [(u32, &str); 3] = [(1_280, "light"), (400, "light"), (400, "dark")];
/// The least size of a text in pixels.
const LEAST_TEXT: f64 = 10.0;

/// No window, no network, and nothing of the user's own profile.
const OPTIONS: [&str; 9] = [
    "--headless",
    "--no-sandbox",
    "--disable-gpu",
    "--disable-background-networking",
    "--disable-component-update",
    "--disable-sync",
    // The script in the frame writes into the page around it.
    "--allow-file-access-from-files",
    "--window-size=1400,2000",
    "--dump-dom",
];

/// Makes the pages and lets the browser measure them.
///
/// # Errors
/// When a page or the browser fails, or anything of a page is cut off, too small or too pale, or does not answer.
pub(super) fn run(place: &Place) -> Result<Vec<String>, Error> {
    let tool = place.tool("motionctl", "motionctl")?;
    let folder = place.target().join("report");
    // Nothing of an earlier run is measured.
    let _ = fs::remove_dir_all(&folder);
    fs::create_dir_all(&folder).map_err(|reason| start(&folder, reason))?;
    let mut pages = Vec::new();
    for (name, options) in SIMULATIONS {
        let page = folder.join(name);
        simulate(place, &tool, options, &page)?;
        pages.push(page);
    }
    let [run, of_log] = ["run", "log"].map(|name| folder.join(name));
    run_on_bench(place, &tool, &folder, &run)?;
    let log = folder.join("run.log");
    place.run(
        place
            .command(&tool)
            .arg("decode")
            .arg(log)
            .arg("--report")
            .arg(&of_log)
            .stdout(Stdio::null()),
    )?;
    pages.extend([run, of_log]);
    for page in &pages {
        for (width, scheme) in SCREENS {
            check(place, page, width, scheme)?;
        }
    }
    Ok(Vec::new())
}

fn simulate(place: &Place, tool: &Path, options: &[&str], page: &Path) -> Result<(), Error> {
    let program = "motionctl sim --report";
    let status = place
        .command(tool)
        .arg("sim")
        .args(options)
        .arg("--report")
        .arg(page)
        .stdout(Stdio::null())
        .status()
        .map_err(|reason| start(program, reason))?;
    if status.success() || status.code() == Some(WITH_FAULTS) {
        return Ok(());
    }
    Err(Error::Failed {
        program: program.into(),
        status,
    })
}

/// A bench that ends with the step.
struct Bench(Child);

impl Drop for Bench {
    fn drop(&mut self) {
        // It may have ended by itself.
        let _ = self.0.kill();
        let _ = self.0.wait();
    }
}

fn run_on_bench(place: &Place, tool: &Path, folder: &Path, page: &Path) -> Result<(), Error> {
    let adapter = folder.join("adapter");
    let bench = place
        .command(tool)
        .args(["bench", "--drives", "1-4", "--slcan"])
        .arg(&adapter)
        .stdout(Stdio::null())
        .spawn()
        .map_err(|reason| start("motionctl bench", reason))?;
    let _bench = Bench(bench);
    let since = Instant::now();
    while !adapter.exists() {
        if since.elapsed() > PATIENCE {
            return Err(Error::Answer {
                program: "motionctl bench".into(),
                expected: "a terminal within 30 s",
            });
        }
        std::thread::sleep(Duration::from_millis(20));
    }
    let mut run: Command = place.command(tool);
    run.args(["run", "--yes", "--slcan"])
        .arg(&adapter)
        .arg("--report")
        .arg(page)
        .arg("--candump")
        .arg(folder.join("run.log"))
        .stdout(Stdio::null());
    place.run(&mut run)
}

/// One page on one screen.
fn check(place: &Place, page: &Path, width: u32, scheme: &str) -> Result<(), Error> {
    let frame = page.join(format!("frame-{width}-{scheme}.html"));
    let made = fs::read_to_string(page.join("index.html"))
        .map(|text| text.replace("</body>", &format!("<script>{MEASURE}</script></body>")))
        .and_then(|text| fs::write(page.join("measured.html"), text))
        .and_then(|()| {
            let text = FRAME
                .replace("WIDTH", &width.to_string())
                .replace("SCHEME", scheme);
            fs::write(&frame, text)
        });
    made.map_err(|reason| start(&frame, reason))?;
    let dom = dom_of(place, &frame)?;
    let measured = Measured::of(&dom).ok_or_else(|| Error::Answer {
        program: "the script that measures the page".into(),
        expected: "what it measured",
    })?;
    let name = page.file_name().unwrap_or_default().to_string_lossy();
    println!(
        "{name} on {width} pixels, {scheme}: {} charts, smallest text {:.1}, begins with {}",
        measured.charts, measured.smallest, measured.begins
    );
    for sentence in &measured.wrong {
        println!("  {sentence}");
    }
    let faults_first = name != "sim" || measured.has_fault;
    let is_right = measured.wrong.is_empty()
        && measured.smallest >= LEAST_TEXT
        && measured.is_dark == (scheme == "dark")
        && measured.charts > 0
        && faults_first;
    if is_right {
        return Ok(());
    }
    Err(Error::Answer {
        program: format!("the page {name} on {width} pixels"),
        expected: "nothing cut off, text of at least 10 pixels, charts that answer, the scheme of the reader",
    })
}

/// What the script measured.
#[derive(Debug, PartialEq)]
struct Measured {
    charts: u64,
    smallest: f64,
    is_dark: bool,
    /// The page names its first fault, and its charts begin there.
    has_fault: bool,
    begins: String,
    wrong: Vec<String>,
}

impl Measured {
    fn of(dom: &str) -> Option<Self> {
        let text = dom.split(MEASURED).nth(1)?.split('"').next()?;
        let text = text
            .replace("&quot;", "\"")
            .replace("&lt;", "<")
            .replace("&gt;", ">")
            .replace("&amp;", "&");
        let value: serde_json::Value = serde_json::from_str(&text).ok()?;
        let begins = value["begins"].as_str()?.to_owned();
        Some(Self {
            charts: value["charts"].as_u64()?,
            smallest: value["smallest"].as_f64()?,
            is_dark: value["dark"].as_bool()?,
            has_fault: begins_at_fault(value["fault"].as_str()?, &begins),
            begins,
            wrong: value["wrong"]
                .as_array()?
                .iter()
                .map(|sentence| sentence.as_str().unwrap_or_default().to_owned())
                .collect(),
        })
    }
}

/// Whether the window `4.101 to 4.601 s` has the time in `First fault, where the charts begin: 4.351171 s ...` in it.
fn begins_at_fault(fault: &str, begins: &str) -> bool {
    let number = |text: &str| text.trim().parse::<f64>().ok();
    let at = fault
        .split_once(": ")
        .and_then(|(_, rest)| number(rest.split(" s").next()?));
    let window = begins
        .trim_end_matches(" s")
        .split_once(" to ")
        .and_then(|(from, to)| Some((number(from)?, number(to)?)));
    match (at, window) {
        (Some(at), Some((from, to))) => from <= at && at <= to && to - from < 1.0,
        _ => false,
    }
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
        .map_err(|reason| start(browser, reason))?;
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

fn start(program: impl AsRef<Path>, reason: std::io::Error) -> Error {
    Error::Start {
        program: program.as_ref().display().to_string(),
        reason,
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_the_page_measured_is_read() {
        let dom = format!(
            "<body {MEASURED}{{&quot;charts&quot;:3,&quot;smallest&quot;:12,&quot;dark&quot;:true,\
             &quot;fault&quot;:&quot;First fault, where the charts begin: 4.351171 s  drive 2&quot;,\
             &quot;begins&quot;:&quot;4.101 to 4.601 s&quot;,&quot;wrong&quot;:[&quot;a &lt; b&quot;]}}\"><main>"
        );
        let expected = Measured {
            charts: 3,
            smallest: 12.0,
            is_dark: true,
            has_fault: true,
            begins: "4.101 to 4.601 s".to_owned(),
            wrong: vec!["a < b".to_owned()],
        };
        assert_eq!(Measured::of(&dom), Some(expected));
        assert_eq!(Measured::of("<body>"), None);
    }

    #[test]
    fn the_first_fault_is_in_the_first_window_or_not() {
        let fault = "First fault, where the charts begin: 4.3 s  drive 2: alarm";
        assert!(begins_at_fault(fault, "4.1 to 4.6 s"));
        assert!(!begins_at_fault(fault, "4.4 to 4.6 s"));
        assert!(
            !begins_at_fault(fault, "0.0 to 9.0 s"),
            "everything is no begin"
        );
        assert!(!begins_at_fault("", "4.1 to 4.6 s"));
    }
}
