//! `motionctl limits`: how much a bus carries, measured on the simulated one.

mod error;
mod figures;
mod measure;
mod payload;
mod stand;
mod tap;

use std::process::ExitCode;

use indicatif::{ProgressBar, ProgressStyle};

use crate::counted::counted;
use crate::exit;
use crate::output::{print, print_json};
use error::LimitsError;
use figures::{Figures, Polled, SetPointsOnly, WireShare};
use measure::Bounds;
use stand::{CYCLE_US, Load, MOST_AXES, PayloadKind, Stand};

const EXAMPLES: &str = "\
Examples:
  motionctl limits                  measure, and compare with the targets
  motionctl limits --json           the same for other programs
  motionctl limits --cycles 2000    a first look

Exit status: 0 every target met, 1 a target missed.";

/// Response delays of polled drives.
const DELAYS_US: [u32; 3] = [200, 500, 2_000];
/// Axes and response delay at which jitter, skew and outage are measured.
const USUAL_AXES: usize = 8;
const USUAL_DELAY_US: u32 = 500;
const OUTAGE_US: u64 = 10_000;
/// Distance of the moments in the cycle at which outages begin.
const OUTAGE_STEP_US: usize = 50;
/// Cycles before an outage, and from its begin on.
const OUTAGE_CYCLES: (u64, u64) = (40, 60);
/// Polls may be this old.
const OLDEST_POLL_PERIODS: f64 = 1.5;
/// Longest set-points may go in one direction only, so a run ends before an axis leaves its travel.
const MOST_CYCLES: u64 = 20_000;
/// Cycles between two updates of the progress bar.
const PROGRESS_STEP: u64 = 500;

/// Options of `motionctl limits`.
#[derive(Debug, clap::Args)]
#[command(after_help = EXAMPLES)]
pub(crate) struct Arguments {
    /// Cycles for each number of axes, at most 20000: beyond, some axes leave their travel.
    #[arg(long, value_name = "N", default_value_t = 20_000, value_parser = clap::value_parser!(u64).range(100..=MOST_CYCLES))]
    cycles: u64,
    /// Seed of payloads and response delays.
    #[arg(long, value_name = "N", default_value_t = 1)]
    seed: u64,
    /// Print the figures as JSON, and no progress.
    #[arg(long)]
    json: bool,
}

/// Measures everything and prints it.
pub(crate) fn run(arguments: &Arguments) -> Result<ExitCode, LimitsError> {
    let figures = Session::new(arguments)?.measure()?;
    if arguments.json {
        print_json(&figures).map_err(LimitsError::Print)?;
    } else {
        print(&figures).map_err(LimitsError::Print)?;
    }
    Ok(if figures.targets_met {
        ExitCode::SUCCESS
    } else {
        exit::BROKEN_PROMISE.into()
    })
}

fn oldest_poll(periods: Option<f64>) -> String {
    periods.map_or_else(
        || "a poll never had a reply".to_owned(),
        |periods| format!("oldest poll {periods:.2} periods"),
    )
}

/// Sums over all runs that count.
#[derive(Debug)]
struct Totals {
    own_collisions: u64,
    bound_violations: u64,
    /// `None` when a poll never had a reply.
    worst_poll_age_periods: Option<f64>,
}

struct Session {
    cycles: u64,
    seed: u64,
    bar: ProgressBar,
    totals: Totals,
}

/// The largest number of axes, and what was seen there.
struct Largest {
    axes: usize,
    one_more: String,
    wire_share: f64,
    worst_poll_age_periods: Option<f64>,
    bounds: Bounds,
}

impl Session {
    fn new(arguments: &Arguments) -> Result<Self, LimitsError> {
        let style = ProgressStyle::with_template("{msg:40} {bar:30} {pos}/{len} cycles");
        let bar = match style {
            Ok(style) if !arguments.json => ProgressBar::new(arguments.cycles).with_style(style),
            _ => ProgressBar::hidden(),
        };
        Ok(Self {
            cycles: arguments.cycles,
            seed: arguments.seed,
            bar,
            totals: Totals {
                own_collisions: 0,
                bound_violations: 0,
                worst_poll_age_periods: Some(0.0),
            },
        })
    }

    fn measure(mut self) -> Result<Figures, LimitsError> {
        let set_points_only = self.largest(None)?;
        let mut polled = Vec::new();
        let mut polled_share = (0, 0.0);
        for delay_us in DELAYS_US {
            let largest = self.largest(Some(delay_us))?;
            if largest.axes > polled_share.0 {
                polled_share = (largest.axes, largest.wire_share);
            }
            polled.push(Polled {
                delay_us,
                axes: largest.axes,
                one_more: largest.one_more,
                worst_poll_age_periods: largest.worst_poll_age_periods,
                bounds: largest.bounds,
            });
        }
        let (jitter_bits, skew_ratio) = self.regularity()?;
        let late_after_outage = self.outage()?;
        self.bar.finish_and_clear();
        Ok(Figures {
            targets_met: false,
            cycles: self.cycles,
            set_points_only: SetPointsOnly {
                axes: set_points_only.axes,
            },
            polled,
            jitter_bits,
            skew_ratio,
            wire_share: WireShare {
                polled: polled_share.1,
                set_points_only: set_points_only.wire_share,
            },
            late_after_outage,
            own_collisions: self.totals.own_collisions,
            bound_violations: self.totals.bound_violations,
            worst_poll_age_periods: self.totals.worst_poll_age_periods,
        }
        .judged())
    }

    /// The largest number of axes that the master takes and that has no late cycle with the longest set-points.
    fn largest(&mut self, delay_us: Option<u32>) -> Result<Largest, LimitsError> {
        let mut one_more = format!("more than {MOST_AXES} axes were not tried");
        for axes in (1..=MOST_AXES).rev() {
            let load = Load {
                axes,
                delay_us,
                payload: PayloadKind::Worst,
                seed: self.seed,
            };
            let mut stand = match Stand::new(&load) {
                Ok(stand) => stand,
                Err(LimitsError::Refused(error)) => {
                    one_more = error.to_string();
                    continue;
                }
                Err(error) => return Err(error),
            };
            self.stream(&mut stand, &load)?;
            let poll_age = stand.worst_poll_age_periods();
            let polls_are_in_time = poll_age.is_some_and(|age| age <= OLDEST_POLL_PERIODS);
            if stand.late() == 0 && polls_are_in_time {
                self.count(&stand);
                return Ok(Largest {
                    axes,
                    one_more,
                    wire_share: stand.measured.wire_share(self.cycles),
                    worst_poll_age_periods: poll_age,
                    bounds: stand.measured.bounds,
                });
            }
            // An admitted load that is late breaks the promise of the plan, whatever the number of axes.
            self.totals.bound_violations += stand.measured.bound_violations;
            one_more = format!("{} late, {}", stand.late(), oldest_poll(poll_age));
        }
        Ok(Largest {
            axes: 0,
            one_more,
            wire_share: 0.0,
            worst_poll_age_periods: Some(0.0),
            bounds: Bounds::default(),
        })
    }

    /// Jitter and skew with random set-points.
    fn regularity(&mut self) -> Result<(u64, f64), LimitsError> {
        let load = self.usual();
        let mut stand = Stand::new(&load)?;
        self.stream(&mut stand, &load)?;
        self.count(&stand);
        Ok((stand.measured.jitter_bits(), stand.measured.skew_ratio()))
    }

    /// Set-points that go out after their cycle when the bus was blocked: the worst over the moment at which that begins.
    fn outage(&mut self) -> Result<u64, LimitsError> {
        let load = self.usual();
        let (before, behind) = OUTAGE_CYCLES;
        let mut worst = 0;
        for after_us in (0..u64::from(CYCLE_US)).step_by(OUTAGE_STEP_US) {
            let mut stand = Stand::new(&load)?;
            stand.stream(before)?;
            stand.block(after_us, OUTAGE_US)?;
            stand.stream(behind)?;
            worst = worst.max(stand.measured.late_set_points);
            self.totals.own_collisions += stand.measured.own_collisions;
        }
        Ok(worst)
    }

    fn usual(&self) -> Load {
        Load {
            axes: USUAL_AXES,
            delay_us: Some(USUAL_DELAY_US),
            payload: PayloadKind::Random,
            seed: self.seed,
        }
    }

    fn stream(&self, stand: &mut Stand, load: &Load) -> Result<(), LimitsError> {
        let polls = match load.delay_us {
            Some(delay_us) => format!("polled, {delay_us} us"),
            None => "set-points only".to_owned(),
        };
        self.bar
            .set_message(format!("{}, {polls}", counted(load.axes, "axis", "axes")));
        let mut done = 0;
        while done < self.cycles {
            self.bar.set_position(done);
            let cycles = PROGRESS_STEP.min(self.cycles - done);
            stand.stream(cycles)?;
            done += cycles;
        }
        Ok(())
    }

    fn count(&mut self, stand: &Stand) {
        let totals = &mut self.totals;
        totals.own_collisions += stand.measured.own_collisions;
        totals.bound_violations += stand.measured.bound_violations;
        totals.worst_poll_age_periods = totals
            .worst_poll_age_periods
            .zip(stand.worst_poll_age_periods())
            .map(|(before, now)| before.max(now));
    }
}

/// The shape of what `--json` prints.
pub(crate) fn schema() -> schemars::Schema {
    crate::schema::of::<figures::Figures>()
}
