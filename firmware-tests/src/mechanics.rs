//! What the shafts of the drives meet: end stops, and a switch on a pin of the board.

use drive_sim::{DynDriveConfig, EndStops, Mechanics, Switch, SwitchSide};
use dyn_can::units::command_counts_per_turn;
use firmware_tests::{Contact, Rig};

/// Stops and switch, in turns from where the shafts stand at power-on.
#[derive(clap::Args)]
pub(crate) struct MechanicsOptions {
    /// End stops of every shaft, in turns from where it stands at the start, as in -2:3
    #[arg(long, value_name = "LOW:HIGH", allow_hyphen_values = true, value_parser = parse_stops)]
    stops: Option<(f64, f64)>,
    /// A switch on pin 3 of port C beside the shaft of one drive, so many turns from where it stands at the start: high from there on, away
    /// from the start
    #[arg(long, value_name = "DRIVE:TURNS", allow_hyphen_values = true, value_parser = parse_switch)]
    switch: Option<(u8, f64)>,
}

impl MechanicsOptions {
    /// A drive with what is beside its shaft.
    pub(crate) fn on(&self, id: u8, config: DynDriveConfig) -> DynDriveConfig {
        let turn = f64::from(command_counts_per_turn(config.group3.gear_number));
        let counts = |turns: f64| (turns * turn).round() as i64;
        let switch = self.switch.filter(|(drive, _)| *drive == id);
        DynDriveConfig {
            mechanics: Mechanics {
                stops: self.stops.map(|(low, high)| EndStops {
                    low_counts: counts(low),
                    high_counts: counts(high),
                }),
                switch: switch.map(|(_, at)| Switch {
                    at_counts: counts(at),
                    side: if at < 0.0 {
                        SwitchSide::Below
                    } else {
                        SwitchSide::Above
                    },
                }),
            },
            ..config
        }
    }

    /// The level of the switch on its pin, as it is now.
    pub(crate) fn connect(&self, rig: &mut Rig) {
        let Some((id, _)) = self.switch else {
            return;
        };
        let now_ns = rig.board().soc().now_ns();
        let of_drive = |drive: &&drive_sim::DynDrive| drive.id().is_some_and(|its| its.get() == id);
        let is_operated = rig
            .servos()
            .find(of_drive)
            .is_some_and(|drive| drive.switch_is_operated(now_ns));
        if is_operated {
            rig.close(Contact::Homing);
        } else {
            rig.open(Contact::Homing);
        }
    }
}

fn parse_stops(text: &str) -> Result<(f64, f64), String> {
    let expected =
        || format!("expected LOW:HIGH in turns with 0 between them, as in -2:3, got {text}");
    let (low, high) = text.split_once(':').ok_or_else(expected)?;
    let (low, high) = (parse_turns(low)?, parse_turns(high)?);
    if low > 0.0 || high < 0.0 || low >= high {
        return Err(expected());
    }
    Ok((low, high))
}

fn parse_switch(text: &str) -> Result<(u8, f64), String> {
    let expected = || format!("expected DRIVE:TURNS, as in 3:-1.5, got {text}");
    let (drive, turns) = text.split_once(':').ok_or_else(expected)?;
    let drive = drive.parse().map_err(|_| expected())?;
    Ok((drive, parse_turns(turns)?))
}

fn parse_turns(text: &str) -> Result<f64, String> {
    match text.parse::<f64>() {
        Ok(turns) if turns.abs() <= 1_000.0 => Ok(turns),
        _ => Err(format!("must be -1000 to 1000 turns, got {text}")),
    }
}
