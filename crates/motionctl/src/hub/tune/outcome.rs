//! The result of a measurement.

use core::fmt;

use comfy_table::Table;
use comfy_table::presets::UTF8_BORDERS_ONLY;
use schemars::JsonSchema;
use serde::Serialize;
use serde_json::{Map, Value};
use zlac8030l::NodeId;

use super::arguments::{Arguments, Of};
use super::gains::{Gains, Loop};
use crate::table::align_numbers;
use crate::tune::{Figures, Panel, Sample};

/// Figures of steps of the speed.
#[derive(Debug, Serialize, JsonSchema)]
struct SpeedFigures {
    samples: usize,
    overshoot_percent: f64,
    rise_ms: Option<f64>,
    settling_ms: Option<f64>,
    speed_error_rms_rpm: f64,
    speed_error_peak_rpm: f64,
    rest_error_rpm: f64,
}

/// Figures in the unit of what was stepped.
#[derive(Debug, Serialize, JsonSchema)]
#[serde(untagged)]
enum Answer {
    Position(Figures),
    Speed(SpeedFigures),
}

/// One set of gains.
#[derive(Debug, Serialize, JsonSchema)]
pub(super) struct Set {
    gains: Map<String, Value>,
    figures: Answer,
    #[serde(skip)]
    words: String,
    #[serde(skip)]
    samples: Vec<Sample>,
}

impl Set {
    pub(super) fn new(
        gains: Gains,
        samples: Vec<Sample>,
        height: i32,
        arguments: &Arguments,
    ) -> Self {
        let hold_ms = f64::from(arguments.hold_ms);
        let figures = Figures::of(&samples, hold_ms, height, 2 * arguments.periods);
        let control = arguments.control();
        Self {
            gains: gains.named(control),
            figures: match arguments.of {
                Of::Position => Answer::Position(figures),
                Of::Speed => Answer::Speed(in_rpm(&figures)),
            },
            words: gains.words(control),
            samples,
        }
    }
}

/// Samples of speeds count 0.1 r/min.
fn in_rpm(figures: &Figures) -> SpeedFigures {
    SpeedFigures {
        samples: figures.samples,
        overshoot_percent: figures.overshoot_percent,
        rise_ms: figures.rise_ms,
        settling_ms: figures.settling_ms,
        speed_error_rms_rpm: figures.following_error_rms_counts / 10.0,
        speed_error_peak_rpm: f64::from(figures.following_error_peak_counts) / 10.0,
        rest_error_rpm: f64::from(figures.rest_error_counts) / 10.0,
    }
}

/// Every set.
#[derive(Debug, Serialize, JsonSchema)]
pub(super) struct Outcome {
    node: u8,
    of: &'static str,
    pub(super) sets: Vec<Set>,
    /// The gains that the drive had, and has again.
    old_gains: Map<String, Value>,
    pub(super) restored: bool,
    /// Gains are changed in the RAM of the drive alone.
    eeprom_writes: u32,
    #[serde(skip)]
    control: Loop,
    #[serde(skip)]
    old: Gains,
}

impl Outcome {
    pub(super) fn new(node: NodeId, arguments: &Arguments, old: &Gains) -> Self {
        let control = arguments.control();
        Self {
            node: node.get(),
            of: match arguments.of {
                Of::Speed => "speed",
                Of::Position => "position",
            },
            sets: Vec::new(),
            old_gains: old.named(control),
            restored: false,
            eeprom_writes: 0,
            control,
            old: old.clone(),
        }
    }

    /// The answers, to be drawn.
    pub(super) fn panels(&self) -> Vec<Panel<'_>> {
        let sets = self.sets.iter();
        sets.map(|set| Panel {
            caption: set.words.clone(),
            samples: &set.samples,
            has_set_points: true,
        })
        .collect()
    }

    /// What the samples count.
    pub(super) const fn axis(&self) -> &'static str {
        match self.control {
            Loop::Speed => "0.1 r/min",
            Loop::Position => "counts",
        }
    }
}

const SPEED_TITLES: [&str; 6] = [
    "overshoot\n%",
    "rise\nms",
    "settling\nms",
    "error rms\nr/min",
    "error peak\nr/min",
    "at rest\nr/min",
];

impl SpeedFigures {
    fn cells(&self) -> [String; 6] {
        let ms =
            |value: Option<f64>| value.map_or_else(|| "never".to_owned(), |ms| format!("{ms:.1}"));
        [
            format!("{:.1}", self.overshoot_percent),
            ms(self.rise_ms),
            ms(self.settling_ms),
            format!("{:.1}", self.speed_error_rms_rpm),
            format!("{:.1}", self.speed_error_peak_rpm),
            format!("{:.1}", self.rest_error_rpm),
        ]
    }
}

impl fmt::Display for Outcome {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let mut table = Table::new();
        let titles = match self.control {
            Loop::Speed => SPEED_TITLES,
            Loop::Position => Figures::TITLES,
        };
        let titles = ["gains"].into_iter().chain(titles);
        table.load_style(UTF8_BORDERS_ONLY).set_header(titles);
        for set in &self.sets {
            let cells = match &set.figures {
                Answer::Position(figures) => figures.cells(),
                Answer::Speed(figures) => figures.cells(),
            };
            table.add_row([set.words.clone()].into_iter().chain(cells));
        }
        align_numbers(&mut table);
        writeln!(f, "{table}")?;
        write!(
            f,
            "node {} has no power and its old gains: {}. EEPROM: 0 writes",
            self.node,
            self.old.words(self.control)
        )
    }
}
