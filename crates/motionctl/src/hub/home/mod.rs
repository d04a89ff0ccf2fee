//! `motionctl home --drives zlac`: finds where the axis of a hub motor is, and keeps it.

mod arguments;
mod plan;
mod search;
mod store;
mod switch;

use std::process::ExitCode;

use homing::{Abort, Home};
use zlac8030l::{ControlWord, Mode, SdoRequest, objects};

use super::bus::Bus;
use super::error::HubError;
use super::for_now::ForNow;
use super::frames;
use super::look::Look;
use crate::confirm::confirm;
use crate::drives::{Step, When};
use crate::dry_run;
use crate::exit;
use crate::home::{HomeError, Outcome, Whose};
use crate::interrupt;
use crate::origins::Origins;
use crate::output::{print, print_json, tell};
pub(super) use arguments::Arguments;
use plan::Plan;
pub(super) use store::life;
use switch::Switch;

/// How a search ended.
#[derive(Debug, Clone, Copy)]
enum Ended {
    Found(Home),
    Failed(Abort),
    Interrupted,
}

/// Checks, asks, searches, and keeps what was found.
pub(super) fn run(arguments: &Arguments) -> Result<ExitCode, HubError> {
    let node = arguments.node.get()?;
    arguments.search.check(&plan::HUB)?;
    if arguments.dry_run {
        dry_run::show(frames(arguments)?, arguments.json).map_err(HubError::Print)?;
        return Ok(ExitCode::SUCCESS);
    }
    let mut origins = match &arguments.origins {
        Some(path) => Some(Origins::read_or_begin(path).map_err(HomeError::Origins)?),
        None => None,
    };
    let mut bus = Bus::open(&arguments.link)?;
    let look = Look::at(&mut bus, node)?;
    let plan = Plan::new(arguments, &mut bus, &look)?;
    let switch = match &arguments.search.switch_input {
        Some(path) => Some(Switch::open(path, &mut bus, node)?),
        None => None,
    };
    confirm(&arguments.question(&look)?, arguments.yes).map_err(HubError::NotConfirmed)?;
    if let Some(origins) = &mut origins {
        // Whatever happens from here on, the old origin is not used.
        let forgotten = origins.forget_wheel(node.get());
        forgotten.map_err(HomeError::Origins)?;
    }
    interrupt::listen_in_motion().map_err(HubError::Interrupt)?;
    if !arguments.json && arguments.search.moves() {
        tell(format_args!(
            "node {node} is being enabled and searches; Ctrl-C stops it"
        ));
    }
    let ended = if arguments.search.moves() {
        let mut lowered = ForNow::new(&mut bus, node)?;
        let searched = plan
            .lower_current(&mut lowered, &mut bus)
            .and_then(|()| search::search(&mut bus, &plan, switch.as_ref()));
        let stopped = |error| match error {
            // Before anything moved: the same end as later.
            HubError::Interrupted => Ok(Ended::Interrupted),
            error => Err(error),
        };
        lowered.end(&mut bus, searched.or_else(stopped))?
    } else {
        search::stand(&mut bus, &plan)?
    };
    let whose = Whose::Node(node.get());
    let (search, path) = (&arguments.search, arguments.origins.as_deref());
    let outcome = match &ended {
        Ended::Found(home) => {
            let kept = store::keep(arguments, &mut bus, &plan, home, origins)?;
            Outcome::found(whose, search, path, home, &kept)
        }
        Ended::Failed(abort) => {
            let reason = format!("{abort}{}", arguments.hint(abort));
            Outcome::failed(whose, search, reason, false)
        }
        Ended::Interrupted => {
            Outcome::failed(whose, search, "stopped by the user".to_owned(), false)
        }
    };
    if arguments.json {
        print_json(&outcome).map_err(HubError::Print)?;
    } else {
        print(&outcome).map_err(HubError::Print)?;
    }
    Ok(match ended {
        Ended::Found(_) => ExitCode::SUCCESS,
        Ended::Failed(_) => exit::BROKEN_PROMISE.into(),
        Ended::Interrupted => exit::INTERRUPTED.into(),
    })
}

/// What would go out; how often, and where to, depends on what the drive tells.
fn frames(arguments: &Arguments) -> Result<Vec<Step>, HubError> {
    let node = arguments.node.get()?;
    let add = |when, request: SdoRequest| frames::transfer(when, node, request);
    let mut steps: Vec<Step> = [
        objects::DEVICE_TYPE.read(),
        objects::VENDOR_ID.read(),
        objects::PRODUCT_CODE.read(),
        objects::STATUS_WORD.read(),
        objects::FAULT_CODE.read(),
        objects::ENCODER_LINES.read(),
        objects::ACTUAL_POSITION.read(),
    ]
    .into_iter()
    .map(|read| add(When::Before, read))
    .collect();
    if arguments.search.moves() {
        let off = objects::EEPROM_UPDATE.write(objects::EEPROM_UPDATE_OFF);
        steps.push(add(When::Always, off));
        steps.push(add(When::Before, plan::max_current()?.read()));
        let mode = objects::MODE.write(Mode::Position.value());
        steps.push(add(When::IfDifferent, mode));
        for word in [
            ControlWord::SHUTDOWN,
            ControlWord::SWITCH_ON,
            ControlWord::ENABLE_OPERATION,
        ] {
            steps.push(add(When::Always, objects::CONTROL_WORD.write(word.get())));
        }
        let target = objects::TARGET_POSITION.write(arguments.search.sign());
        steps.push(add(When::Always, target));
        let disable = ControlWord::DISABLE_VOLTAGE.get();
        steps.push(add(When::Always, objects::CONTROL_WORD.write(disable)));
    }
    if arguments.in_drive {
        for object in [
            objects::CLEAR_FEEDBACK_POSITION,
            objects::CLEAR_ABSOLUTE_POSITION,
        ] {
            steps.push(add(When::Always, object.write(1)));
        }
    }
    if arguments.origins.is_some() {
        steps.push(add(When::Always, store::mark_request(1)?));
    }
    Ok(steps)
}

/// The shape of what `--json` prints.
pub(super) fn schema() -> schemars::Schema {
    crate::schema::of::<Outcome>()
}
