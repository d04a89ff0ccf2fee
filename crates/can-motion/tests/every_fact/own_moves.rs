//! What changes of a motion that the drive makes by itself promise.

use can_motion::MoveEnd;
use can_motion::facts::{Class, Facts, Goal, Input, Knowledge, Loss, Motion, Power};

use crate::promises::{asks_to_move, sends};
use crate::walk::{Held, hold};

/// Promise 1, for motions of the drive itself.
pub(crate) fn nothing_moves_by_itself(
    before: Facts,
    input: Input,
    after: Facts,
    is_taken: bool,
) -> Held {
    hold(
        !asks_to_move(&after)
            || before.goal == after.goal
            || (matches!(input, Input::Move | Input::SyncMove) && is_taken),
        "a drive is asked to move by itself only by a command",
    )?;
    of_motion(before, input, after)?;
    match input {
        Input::MoveEnded(end) => of_the_end(before, end, after),
        Input::Arm => hold(
            !is_taken || after.motion == Motion::Armed,
            "a drive that answered since its move was loaded may be triggered",
        ),
        _ => Ok(()),
    }
}

/// Where each motion of a drive may come from, and what it may become.
fn of_motion(before: Facts, input: Input, after: Facts) -> Held {
    let is_off = after.power == Power::Off;
    let is_accepted = |class| input == Input::Accepted(class);
    let is_returned = |class| input == Input::Displaced(class);
    let may_be = match (before.motion, after.motion) {
        (one, other) if one == other => true,
        (Motion::Rest, Motion::DriveMove) => {
            is_accepted(Class::DriveMove) && before.goal == Goal::Move
        }
        (Motion::Rest, Motion::Loaded) => is_accepted(Class::Load) && before.goal == Goal::SyncMove,
        (Motion::Loaded, Motion::Armed) => input == Input::Arm && before.goal == Goal::SyncMove,
        (Motion::Armed, Motion::DriveMove) => {
            is_accepted(Class::Trigger) && before.goal == Goal::SyncMove
        }
        (Motion::Loaded | Motion::Armed, Motion::Rest) => is_off || is_returned(Class::Load),
        (Motion::DriveMove, Motion::Armed) => {
            is_returned(Class::Trigger) && before.goal == Goal::SyncMove
        }
        (Motion::DriveMove, Motion::Loaded) => {
            is_returned(Class::Trigger)
                && !asks_to_move(&before)
                && after.knowledge <= Knowledge::Checked
        }
        (Motion::DriveMove, Motion::Rest) => {
            let lets_go = matches!(
                input,
                Input::Fault {
                    loss: Loss::Drive,
                    ..
                }
            );
            let is_end = matches!(input, Input::MoveEnded(_)) || is_returned(Class::DriveMove);
            is_off || is_end || lets_go
        }
        _ => sends(&before) || sends(&after),
    };
    hold(
        may_be,
        "a motion of the drive begins by its frame and ends when the drive says so, has no power, or never got the frame",
    )?;
    let is_cut = before.motion == Motion::DriveMove && is_off;
    hold(
        !is_cut || after.knowledge <= Knowledge::Checked,
        "a drive that lost its power on its way is anchored anew",
    )?;
    hold(
        !sends(&after) || sends(&before) || before.motion == Motion::Rest,
        "set-points begin when the drive does not move by itself",
    )
}

fn of_the_end(before: Facts, end: MoveEnd, after: Facts) -> Held {
    if before.motion != Motion::DriveMove {
        return hold(before == after, "only what moves by itself can arrive");
    }
    hold(after.motion == Motion::Rest, "a motion that ended is over")?;
    let goal = match (end, before.goal) {
        (MoveEnd::OtherMode, _) | (_, Goal::Off) => Goal::Off,
        _ => Goal::Hold,
    };
    hold(after.goal == goal, "what arrived holds")?;
    let most = match end {
        MoveEnd::Arrived => Knowledge::Anchored,
        MoveEnd::Elsewhere => Knowledge::Checked,
        MoveEnd::OtherMode => Knowledge::Unknown,
    };
    hold(
        after.knowledge == before.knowledge.min(most),
        "a drive that is not where it was told to go is anchored anew",
    )
}

/// The frames that were under way count as what they are for.
pub(crate) fn frames_count(before: Facts, input: Input, after: Facts) -> Held {
    let expected = match (input, before.goal, before.motion) {
        (Input::Accepted(Class::DriveMove), Goal::Move, _) => Motion::DriveMove,
        (Input::Accepted(Class::Load), Goal::SyncMove, _) => Motion::Loaded,
        (Input::Accepted(Class::Trigger), Goal::SyncMove, _) => Motion::DriveMove,
        (
            Input::Displaced(Class::DriveMove),
            Goal::Move | Goal::Hold | Goal::Off,
            Motion::DriveMove,
        ) => Motion::Rest,
        (Input::Displaced(Class::Load), _, Motion::Loaded | Motion::Armed) => Motion::Rest,
        (Input::Displaced(Class::Trigger), Goal::SyncMove, Motion::DriveMove) => Motion::Armed,
        (Input::Displaced(Class::Trigger), Goal::Off | Goal::Hold, Motion::DriveMove) => {
            Motion::Loaded
        }
        (Input::Accepted(_) | Input::Displaced(_), ..) => before.motion,
        _ => return Ok(()),
    };
    hold(
        after.motion == expected,
        "what becomes of a frame for a motion of the drive is known",
    )
}
