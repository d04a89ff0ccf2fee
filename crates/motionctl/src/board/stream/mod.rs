//! `motionctl board stream`: set-points of another program on the drives of a board.
//!
//! [`taker`] makes segments of set-points within [`limits`], [`columns`] says which axes they are for, [`motion`] hands them to the board and answers the sender.

mod arguments;
mod columns;
mod limits;
mod motion;
mod taker;

use std::process::ExitCode;

use board_link::AxisLimits;
use board_link::host::SegmentMakerConfig;
use board_link::message::Info;
use dyn_can::DriveId;
use schemars::JsonSchema;
use serde::Serialize;
use trajectory::Time;

use super::error::BoardError;
use super::motion::{Axis, BoardRecording, Follow, OfBoard, Outcome};
use super::session::Session;
use crate::confirm::confirm;
use crate::control::{ControlSocket, Listening, Wishes};
use crate::drive_ids::about;
use crate::endpoint::Endpoint;
use crate::interrupt;
use crate::output::{print, print_json, tell};
use crate::report;
use crate::stream::{LONGEST_GAP_S, Open, StreamReport};
use crate::trajectory::MotionError;
pub(super) use arguments::Arguments;
use columns::Columns;
use limits::StreamLimits;
use motion::StreamMotion;
use taker::{Setup, Taker};

/// The memory of a board must last for so many milliseconds, or it always slows down.
const LEAST_KEPT_MS: u32 = 300;

/// Everything that came of a stream.
#[derive(Serialize, JsonSchema)]
struct StreamResult<'a> {
    #[serde(flatten)]
    outcome: &'a Outcome,
    stream: StreamReport,
}

/// What was checked before anything is asked.
struct Prepared {
    of_board: OfBoard,
    axes: Vec<Axis>,
    setup: Setup,
}

/// Checks everything, asks, takes set-points, prints the summary.
pub(super) fn run(arguments: &Arguments) -> Result<ExitCode, BoardError> {
    if arguments.recording.candump.is_some() {
        return Err(BoardError::NoFrames);
    }
    if arguments.motion.file().is_some() {
        return Err(BoardError::FileOfStream);
    }
    let wishes = Wishes::new();
    let control = arguments
        .control
        .open(&wishes)
        .map_err(BoardError::Control)?;
    let open = Open::new(&arguments.endpoint, arguments.control.allow_remote);
    let open = open.map_err(BoardError::Control)?;
    let mut session = Session::open(&arguments.port, false)?;
    let prepared = prepare(arguments, &mut session)?;
    let recording = BoardRecording::open(
        &arguments.recording,
        &arguments.port.port,
        None,
        (&prepared.axes, prepared.setup.cycle_us),
    )?;
    ask(arguments, &prepared, &open.place())?;
    session.take_command()?;
    let way = Way {
        session,
        open,
        control,
        recording,
    };
    let (outcome, stream) = play(arguments, &wishes, way, prepared)?;
    let result = StreamResult {
        outcome: &outcome,
        stream,
    };
    show(arguments, &result)
}

fn prepare(arguments: &Arguments, session: &mut Session) -> Result<Prepared, BoardError> {
    let info = session.info();
    let port = session.name().to_owned();
    let settings = session.settings()?;
    let settings = settings.ok_or(BoardError::NoSettings { port })?;
    let of_board = OfBoard::new(&info.board, &settings)?;
    let drives = match arguments.motion.drives_of_stream() {
        // Those of the board.
        Err(MotionError::DrivesOfStream) => of_board.drives.clone(),
        drives => drives.map_err(BoardError::Motion)?,
    };
    let gears = arguments.motion.gears_of_stream(drives.len());
    let gears = gears.map_err(BoardError::Motion)?;
    let limits = &arguments.limits;
    let axes =
        of_board.axes_of_stream(&drives, &gears, |gear| limits.as_needs(gear, info.cycle_us))?;
    let origins = session.origins(of_board.drives.len())?;
    let limits = of_board.limits_from(&origins)?;
    let setup = setup(arguments, &info, &limits, &axes)?;
    Ok(Prepared {
        of_board,
        axes,
        setup,
    })
}

fn setup(
    arguments: &Arguments,
    info: &Info,
    of_board: &[AxisLimits],
    axes: &[Axis],
) -> Result<Setup, BoardError> {
    let cycle_us = info.cycle_us;
    let ms = |ms: u32| Time::from_units(u64::from(ms) * 1_000, cycle_us);
    let axis = |axis: &Axis| {
        let jerk = arguments.buffer.max_jerk;
        let of_options = arguments.limits.of_stream(axis.gear, cycle_us, jerk)?;
        StreamLimits::new(of_board[axis.place], of_options).map(|limits| (axis.place, limits))
    };
    let limits: Result<Vec<_>, _> = axes.iter().map(axis).collect();
    Ok(Setup {
        cycle_us,
        buffering: arguments.buffer.in_cycles(cycle_us),
        maker: SegmentMakerConfig {
            longest_gap: ms(LONGEST_GAP_S * 1_000),
            kept: info.segments.into(),
            least_kept: ms(LEAST_KEPT_MS),
        },
        columns: Columns::new(limits.map_err(BoardError::Range)?, of_board.to_vec()),
    })
}

/// Asks whether the motors may move, and listens to signals from then on.
fn ask(arguments: &Arguments, prepared: &Prepared, place: &str) -> Result<(), BoardError> {
    let drives: Vec<DriveId> = prepared.axes.iter().map(|axis| axis.drive).collect();
    let question = format!(
        "{} as {place} says, {}. Is everybody clear of the machine?",
        about(
            &drives,
            "will be enabled and its motor will MOVE",
            "will be enabled and their motors will MOVE"
        ),
        arguments.limits
    );
    confirm(&question, arguments.yes).map_err(BoardError::NotConfirmed)?;
    interrupt::listen_in_motion().map_err(BoardError::Interrupt)?;
    if !arguments.json {
        tell(format_args!("limits: {}", arguments.limits));
    }
    Ok(())
}

/// What is open: to the board, to the sender, to those who give orders, to the files.
struct Way {
    session: Session,
    open: Open,
    control: Option<ControlSocket>,
    recording: BoardRecording,
}

/// Enables, moves, disables.
fn play(
    arguments: &Arguments,
    wishes: &Wishes,
    way: Way,
    prepared: Prepared,
) -> Result<(Outcome, StreamReport), BoardError> {
    let Way {
        mut session,
        open,
        control,
        mut recording,
    } = way;
    let Prepared {
        of_board,
        axes,
        setup,
    } = prepared;
    // Whoever waits for it may come now; nothing moves before the drives are enabled.
    tell(format_args!("set-points are taken from {}", open.place()));
    let (sender, conversation) = open
        .admit(&arguments.motion, axes.len(), setup.cycle_us)
        .map_err(BoardError::Interrupt)?;
    let takes_keys = arguments.endpoint != Endpoint::StandardInput;
    let listening = Listening::new(control, wishes, takes_keys).map_err(BoardError::Interrupt)?;
    if !arguments.json
        && let Some(help) = listening.help()
    {
        tell(help);
    }
    let mut motion = StreamMotion::new(conversation, Taker::new(setup));
    let follow = Follow::new(&mut session, &of_board, &mut motion, &mut recording);
    let followed = follow.run(wishes, arguments.snapshot_hz, !arguments.json);
    drop(listening);
    let mut outcome = Outcome::new(&axes, &motion.targets(), motion.segments(), &followed);
    sender.close(outcome.outcome());
    let recorded = recording.finish();
    let folder = arguments.recording.report.as_deref();
    let has_page = report::write_and_tell(folder, &recorded, &outcome.for_page());
    outcome.ending.note_recording(recorded.report, has_page);
    Ok((outcome, motion.report()))
}

fn show(arguments: &Arguments, result: &StreamResult<'_>) -> Result<ExitCode, BoardError> {
    if arguments.json {
        print_json(result).map_err(BoardError::Print)?;
    } else {
        print(result.outcome).map_err(BoardError::Print)?;
        print(&result.stream).map_err(BoardError::Print)?;
    }
    Ok(result.outcome.ending.exit_code())
}

/// The shape of what `--json` prints.
pub(super) fn schema() -> schemars::Schema {
    crate::schema::of::<StreamResult<'_>>()
}
