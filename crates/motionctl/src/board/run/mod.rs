//! `motionctl board run`: a motion on the drives of a board.
//!
//! [`mod@segments`] makes of the motion what the board plays, [`fit`] where it is no curve, [`whole`] hands it over.

mod arguments;
mod fit;
mod segments;
mod whole;

use std::process::ExitCode;

use board_link::message::Origin;
use dyn_can::units::command_counts_per_turn;
use dyn_can::{DriveId, StepLimit};
use schemars::JsonSchema;
use serde::Serialize;

use super::error::BoardError;
use super::motion::{Axis, BoardRecording, Follow, OfBoard, Outcome};
use super::session::Session;
use crate::confirm::confirm;
use crate::control::{Listening, Wishes};
use crate::drive_ids::about;
use crate::interrupt;
use crate::output::{print, print_json, tell};
use crate::report;
use crate::set_points::most_percent;
use crate::trajectory::{MotionReport, Plan};
pub(super) use arguments::Arguments;
use segments::{Played, preview, segments};
use whole::WholeMotion;

/// A homed axis may stand so far from the first position of its motion.
const AT_START_COUNTS: f64 = 32.0;

/// Everything that came of a motion.
#[derive(Serialize, JsonSchema)]
struct RunResult<'a> {
    motion: &'a MotionReport,
    #[serde(flatten)]
    played: Played,
    #[serde(flatten)]
    outcome: &'a Outcome,
}

/// Checks everything, asks, runs the motion, prints the summary.
pub(super) fn run(arguments: &Arguments) -> Result<ExitCode, BoardError> {
    if arguments.recording.candump.is_some() {
        return Err(BoardError::NoFrames);
    }
    let options = arguments.motion();
    let motion = options.read().map_err(BoardError::Motion)?;
    let mut session = Session::open(&arguments.port, false)?;
    let info = session.info();
    let port = session.name().to_owned();
    let settings = session.settings()?;
    let settings = settings.ok_or(BoardError::NoSettings { port })?;
    let of_board = OfBoard::new(&info.board, &settings)?;
    let plan = motion
        .plan(info.cycle_us, StepLimit::MAX)
        .map_err(BoardError::Motion)?;
    let axes = of_board.axes(&motion, &plan, info.cycle_us)?;
    let drives: Vec<DriveId> = axes.iter().map(|axis| axis.drive).collect();
    options.write_path(&plan).map_err(BoardError::Motion)?;
    let told = motion
        .report(&plan, &drives, StepLimit::MAX)
        .map_err(BoardError::Motion)?;
    if !arguments.json {
        told.show();
    }
    for axis in &axes {
        let within = arguments.limits.check(axis.drive, &axis.needs);
        within.map_err(BoardError::Limit)?;
    }
    let limits = &arguments.limits;
    let headroom = |axis: &Axis| limits.headroom(&axis.needs, axis.gear, info.cycle_us);
    let speed = (info.cycle_us, most_percent(axes.iter().map(headroom)));
    let mut motion = prepare(&mut session, &of_board, &plan, (axes, speed))?;
    let recording = BoardRecording::open(
        &arguments.recording,
        &arguments.port.port,
        options.file(),
        (&motion.axes, info.cycle_us),
    )?;
    ask(arguments, &motion)?;
    let outcome = play(arguments, session, &of_board, &mut motion, recording)?;
    let result = RunResult {
        motion: &told,
        played: motion.played,
        outcome: &outcome,
    };
    show(arguments, &result)
}

/// Plays the motion on this computer as the board will, from where the axes stand now.
fn prepare(
    session: &mut Session,
    of_board: &OfBoard,
    plan: &Plan,
    (axes, speed): (Vec<Axis>, (u32, u16)),
) -> Result<WholeMotion, BoardError> {
    let segments = segments(plan)?;
    let (cycle_us, _) = speed;
    let stand = session.snapshot()?;
    let from: Vec<i32> = stand.axes.iter().map(|axis| axis.position).collect();
    let places: Vec<usize> = axes.iter().map(|axis| axis.place).collect();
    let origins = session.origins(of_board.drives.len())?;
    check_starts(plan, &axes, &from, &origins)?;
    let limits = of_board.limits_from(&origins)?;
    let played = preview(&segments, &limits, (&places, &from), cycle_us, |cycle| {
        plan.row(cycle)
    });
    let played = played.map_err(|refusal| {
        let axis = refusal.refused.axis.map(usize::from);
        BoardError::Preview {
            segment: refusal.segment,
            at_s: refusal.at_cycles * f64::from(cycle_us) * 1e-6,
            refused: refusal.refused,
            drive: axis.and_then(|axis| of_board.drives.get(axis).copied()),
        }
    })?;
    Ok(WholeMotion::new(axes, segments, played, plan.last(), speed))
}

/// An axis that was homed must stand where its motion begins; the positions of the motion are its own.
fn check_starts(
    plan: &Plan,
    axes: &[Axis],
    stand: &[i32],
    origins: &[Origin],
) -> Result<(), BoardError> {
    for (column, axis) in axes.iter().enumerate() {
        let (Some(Origin::Found { counts, .. }), Some(stand)) =
            (origins.get(axis.place), stand.get(axis.place))
        else {
            continue;
        };
        let (first, here) = (
            plan.first_counts(column),
            f64::from(*stand) - f64::from(*counts),
        );
        if (here - first).abs() > AT_START_COUNTS {
            let turn = f64::from(command_counts_per_turn(axis.gear));
            return Err(BoardError::Start {
                drive: axis.drive,
                expected_turns: first / turn,
                actual_turns: here / turn,
            });
        }
    }
    Ok(())
}

/// Asks whether the motors may move, and listens to signals from then on.
fn ask(arguments: &Arguments, motion: &WholeMotion) -> Result<(), BoardError> {
    let seconds = motion.played.cycles as f64 * f64::from(motion.cycle_us) * 1e-6;
    let question = format!(
        "{} for {seconds:.1} s, {}. Is everybody clear of the machine?",
        about(
            &motion.drives(),
            "will be enabled and its motor will MOVE",
            "will be enabled and their motors will MOVE"
        ),
        arguments.limits
    );
    confirm(&question, arguments.yes).map_err(BoardError::NotConfirmed)?;
    interrupt::listen_in_motion().map_err(BoardError::Interrupt)?;
    if motion.played.worst_counts > 0 {
        tell(format_args!(
            "note: set-points differ from those of `motionctl run` by up to {} counts",
            motion.played.worst_counts
        ));
    }
    Ok(())
}

/// Enables, moves, disables.
fn play(
    arguments: &Arguments,
    mut session: Session,
    of_board: &OfBoard,
    motion: &mut WholeMotion,
    mut recording: BoardRecording,
) -> Result<Outcome, BoardError> {
    let wishes = Wishes::new();
    let control = arguments
        .control
        .open(&wishes)
        .map_err(BoardError::Control)?;
    session.take_command()?;
    let listening = Listening::new(control, &wishes, true).map_err(BoardError::Interrupt)?;
    if !arguments.json
        && let Some(help) = listening.help()
    {
        tell(help);
    }
    let follow = Follow::new(&mut session, of_board, motion, &mut recording)
        .staying_enabled(arguments.stay_enabled);
    let followed = follow.run(&wishes, arguments.snapshot_hz, !arguments.json);
    drop(listening);
    let segments = motion.segments.len() as u32;
    let mut outcome = Outcome::new(&motion.axes, &motion.last, segments, &followed);
    let recorded = recording.finish();
    let folder = arguments.recording.report.as_deref();
    let has_page = report::write_and_tell(folder, &recorded, &outcome.for_page());
    outcome.ending.note_recording(recorded.report, has_page);
    Ok(outcome)
}

fn show(arguments: &Arguments, result: &RunResult<'_>) -> Result<ExitCode, BoardError> {
    if arguments.json {
        print_json(result).map_err(BoardError::Print)?;
    } else {
        print(result.outcome).map_err(BoardError::Print)?;
    }
    Ok(result.outcome.ending.exit_code())
}

/// The shape of what `--json` prints.
pub(super) fn schema() -> schemars::Schema {
    crate::schema::of::<RunResult<'_>>()
}
