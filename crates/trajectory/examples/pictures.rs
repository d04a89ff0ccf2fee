//! Draws the pictures of the documentation: `cargo run -p trajectory --example pictures`. With `--check` it only compares, and exits
//! with 1 when a picture in docs/ is not what would be drawn.

use std::error::Error;
use std::path::Path;
use std::process::ExitCode;
use std::{env, fs};

use plotters::prelude::*;
use trajectory::{Limits, Position, Profile, State, Time, TimeScale, Tracker};

/// Counts per cycle, per cycle² and per cycle³.
const VELOCITY: f32 = 40.0;
const ACCELERATION: f32 = 1.0;
const JERK: f32 = 0.05;
const SIZE: (u32, u32) = (640, 420);

/// Time in cycles, then position, velocity and acceleration.
type Point = (f32, [f32; 3]);

struct Picture {
    name: &'static str,
    title: &'static str,
    points: Vec<Point>,
}

fn main() -> Result<ExitCode, Box<dyn Error>> {
    let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("docs");
    let checks = env::args().any(|argument| argument == "--check");
    let mut differs = false;
    for picture in pictures()? {
        let path = folder.join(picture.name).with_extension("svg");
        let drawn = draw(&picture)?;
        if !checks {
            fs::write(&path, drawn)?;
        } else if fs::read_to_string(&path)? != drawn {
            eprintln!(
                "{} is not what would be drawn: run this again without --check",
                path.display()
            );
            differs = true;
        }
    }
    Ok(if differs {
        ExitCode::FAILURE
    } else {
        ExitCode::SUCCESS
    })
}

fn pictures() -> Result<Vec<Picture>, Box<dyn Error>> {
    let limits = Limits::new(VELOCITY, ACCELERATION, JERK)?;
    let trapezoid = Limits::without_jerk(VELOCITY, ACCELERATION)?;
    let start = |velocity, acceleration| State {
        velocity,
        acceleration,
        ..State::at_rest(0)
    };
    let to = |start: State, counts, limits| -> Result<_, Box<dyn Error>> {
        Ok(profile(&Profile::to_rest(
            &start,
            Position::from_counts(counts),
            limits,
        )?))
    };
    let all = [
        (
            "rest-to-rest",
            "From rest to rest",
            to(State::at_rest(0), 5_000, &limits)?,
        ),
        (
            "one-count",
            "One count away",
            to(State::at_rest(0), 1, &limits)?,
        ),
        (
            "target-behind",
            "The target is behind",
            to(start(35.0, 0.0), 200, &limits)?,
        ),
        (
            "brakes-later",
            "Brakes already, and has to brake later",
            to(start(35.0, -0.9), 700, &limits)?,
        ),
        (
            "beyond-limits",
            "Velocity and acceleration beyond their limits",
            to(start(60.0, 1.8), 6_000, &limits)?,
        ),
        (
            "trapezoid",
            "Without a limit of the jerk",
            to(State::at_rest(0), 5_000, &trapezoid)?,
        ),
        (
            "stop",
            "Stop while accelerating",
            profile(&Profile::stop(&start(25.0, 0.8), &limits)?),
        ),
        (
            "jog",
            "From one velocity to another",
            profile(&Profile::to_velocity(&start(30.0, 0.0), -20.0, &limits)?),
        ),
        (
            "override",
            "Override 50 %, pause, 150 %",
            overridden(&limits)?,
        ),
        (
            "moving-target",
            "A target that moves, followed without lag",
            followed(limits)?,
        ),
    ];
    Ok(all
        .map(|(name, title, points)| Picture {
            name,
            title,
            points,
        })
        .into())
}

fn point(at: f32, state: &State) -> Point {
    let counts = state.position.units() as f32 / Position::UNITS as f32;
    (at, [counts, state.velocity, state.acceleration])
}

/// The whole profile and a little rest at both ends.
fn profile(profile: &Profile) -> Vec<Point> {
    const POINTS: u64 = 160;
    let end = profile.duration().ticks();
    let at = |point| Time::from_ticks(end / POINTS * point);
    (0..=POINTS + 10)
        .map(|place| point(at(place).cycles(), &profile.state(at(place))))
        .collect()
}

/// A move whose time is scaled; velocity and acceleration as differences of the positions of four cycles.
fn overridden(limits: &Limits) -> Result<Vec<Point>, Box<dyn Error>> {
    let profile = Profile::to_rest(&State::at_rest(0), Position::from_counts(8_000), limits)?;
    let mut scale = TimeScale::running(40)?;
    let mut positions = Vec::new();
    for cycle in 0..520_u32 {
        match cycle {
            80 => scale.set_override(50)?,
            180 => scale.pause(),
            280 => scale.resume(),
            330 => scale.set_override(150)?,
            _ => {}
        }
        let units = profile.position(scale.advance()).units();
        positions.push(units as f32 / Position::UNITS as f32);
    }
    let span = 4;
    let velocity = |at: usize| (positions[at + span] - positions[at]) / span as f32;
    let points = (0..positions.len() - 2 * span).step_by(3).map(|at| {
        let acceleration = (velocity(at + span) - velocity(at)) / span as f32;
        (at as f32, [positions[at], velocity(at), acceleration])
    });
    Ok(points.collect())
}

/// A target that stands, moves, and moves the other way.
fn followed(limits: Limits) -> Result<Vec<Point>, Box<dyn Error>> {
    let mut tracker = Tracker::at_rest(0, limits);
    let mut target = Position::from_counts(600);
    let mut points = Vec::new();
    for cycle in 0..480_u32 {
        let velocity = match cycle {
            0..150 => 0.0,
            150..320 => 20.0,
            _ => -15.0,
        };
        tracker.follow(target, velocity)?;
        target = target.moved_by(Position::at_velocity(velocity, Time::from_cycles(1)));
        if cycle % 3 == 0 {
            points.push(point(cycle as f32, &tracker.state()));
        }
    }
    Ok(points)
}

fn draw(picture: &Picture) -> Result<String, Box<dyn Error>> {
    let mut text = String::new();
    {
        let area = SVGBackend::with_string(&mut text, SIZE).into_drawing_area();
        area.fill(&WHITE)?;
        let area = area.titled(picture.title, ("sans-serif", 18))?;
        let rows = area.split_evenly((3, 1));
        let names = ["counts", "counts/cycle", "counts/cycle²"];
        let limits = [None, Some(VELOCITY), Some(ACCELERATION)];
        for (quantity, row) in rows.iter().enumerate() {
            draw_row(row, picture, quantity, names[quantity], limits[quantity])?;
        }
        area.present()?;
    }
    Ok(text)
}

/// One quantity over the time, with its limits as grey lines.
fn draw_row(
    row: &DrawingArea<SVGBackend<'_>, plotters::coord::Shift>,
    picture: &Picture,
    quantity: usize,
    name: &str,
    limit: Option<f32>,
) -> Result<(), Box<dyn Error>> {
    let values = picture.points.iter().map(|(_, values)| values[quantity]);
    let (low, high) = values.fold((0.0_f32, 0.0_f32), |(low, high), value| {
        (low.min(value), high.max(value))
    });
    let room = (high - low) * 0.1 + 1e-3;
    let end = picture.points.last().map_or(1.0, |(at, _)| *at);
    let mut chart = ChartBuilder::on(row)
        .margin(6)
        .x_label_area_size(if quantity == 2 { 24 } else { 6 })
        .y_label_area_size(64)
        .build_cartesian_2d(0.0..end, low - room..high + room)?;
    chart
        .configure_mesh()
        .light_line_style(TRANSPARENT)
        .bold_line_style(RGBColor(230, 230, 230))
        .x_labels(if quantity == 2 { 8 } else { 0 })
        .y_labels(4)
        .y_desc(name)
        .draw()?;
    for limit in limit.into_iter().flat_map(|limit| [limit, -limit]) {
        if (low - room..high + room).contains(&limit) {
            let line = LineSeries::new([(0.0, limit), (end, limit)], RGBColor(160, 160, 160));
            chart.draw_series(line)?;
        }
    }
    let line = picture
        .points
        .iter()
        .map(|(at, values)| (*at, values[quantity]));
    chart.draw_series(LineSeries::new(line, RGBColor(30, 90, 180).stroke_width(2)))?;
    Ok(())
}
