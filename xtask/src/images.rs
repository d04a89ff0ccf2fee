//! The images of the firmware that tests and measurements run.

use std::fs;
use std::path::{Path, PathBuf};

use crate::error::Error;
use crate::thumb::{Builder, Variant};

/// The package with the firmware.
pub(crate) const PACKAGE: &str = "motion-board";
/// Its image that sets the option bytes of a chip, and the feature that it needs.
pub(crate) const COMMISSION: &str = "commission";
/// The feature of the image that takes orders.
pub(crate) const LINK: &str = "link";
/// The feature of the same over USB.
pub(crate) const LINK_USB: &str = "link-usb";
/// The feature of the one that takes orders and homes its axes.
pub(crate) const LINK_HOMING: &str = "link-homing";
/// Configuration whose number of axes is in [`AXES`].
const MANY_AXES: &str = "firmware-tests/configs/many_axes.rs";
const AXES: &str = "FIRMWARE_TEST_AXES";
/// Configuration of two servo axes that are homed before they move.
const HOMING: &str = "firmware-tests/configs/homing.rs";
/// A configuration that plays a program.
const PROGRAM: &str = "firmware-tests/configs/program.rs";
/// Configuration of two hub motors that are homed before they move.
const HUB_HOMING: &str = "firmware-tests/configs/hub_homing.rs";
/// Configuration of two hub motors.
const HUB_MOTORS: &str = "firmware-tests/configs/hub_motors.rs";
/// Names the configuration for the build script of the firmware.
pub(crate) const CONFIG: &str = "MOTION_BOARD_CONFIG";

/// The boards, by the features of the firmware.
#[derive(Clone, Copy, Debug, PartialEq, Eq, clap::ValueEnum)]
pub(crate) enum Board {
    /// STM32F405RG, bxCAN: the default.
    Stm32f405,
    /// STM32G474RE, FDCAN in classic mode.
    Stm32g474,
}

impl Board {
    /// Every board.
    pub(crate) const ALL: [Self; 2] = [Self::Stm32f405, Self::Stm32g474];

    /// Its feature.
    pub(crate) const fn feature(self) -> &'static str {
        match self {
            Self::Stm32f405 => "stm32f405",
            Self::Stm32g474 => "stm32g474",
        }
    }

    /// What chooses it on cargo's command line.
    pub(crate) fn arguments(self) -> [String; 3] {
        ["--no-default-features", "--features", self.feature()].map(String::from)
    }
}

/// Where the image of a board lies for the user, below the build products: the boards share the folder of their builds, in which the
/// one would overwrite the other.
const FIRMWARE_FOLDER: &str = "firmware";

/// Copies an image to the place of its board.
///
/// # Errors
/// When it cannot be copied.
pub(crate) fn keep_for_board(image: &Path, board: Board, target: &Path) -> Result<PathBuf, Error> {
    let folder = target.join(FIRMWARE_FOLDER).join(board.feature());
    let place = folder.join(image.file_name().unwrap_or(PACKAGE.as_ref()));
    let copied = fs::create_dir_all(&folder).and_then(|()| fs::copy(image, &place));
    copied.map_err(|reason| Error::Image {
        path: place.clone(),
        reason: reason.to_string(),
    })?;
    Ok(place)
}

/// One image: its name and what makes it differ from the one that `cargo fw` builds.
pub(crate) struct Image {
    /// Name of the file.
    pub(crate) name: String,
    /// Which of the images of the package.
    binary: &'static str,
    variant: Variant,
}

impl Image {
    /// What the tests run on the emulated board, in a folder of the board's name: the image as it is shipped, one that fails on
    /// command, one with eight axes, one that homes its axes, three with hub motors, of which one homes them and one fails on command, the
    /// one that sets the option bytes, and the three that take orders; of the default board one that plays a program, which is the same code on the other one.
    pub(crate) fn for_tests(board: Board) -> Vec<Self> {
        let many = vec![(CONFIG.into(), MANY_AXES.into()), (AXES.into(), "8".into())];
        let homing = vec![(CONFIG.into(), HOMING.into())];
        let hub_homing = vec![(CONFIG.into(), HUB_HOMING.into())];
        let hub_motors = || vec![(CONFIG.into(), HUB_MOTORS.into())];
        // The lines of each second, which tell how many cycles were late; all else is as it is shipped.
        let figures = || vec![("DEFMT_LOG".into(), "debug".into())];
        let misbehaving = "hub-motors-misbehaving";
        let mut images = vec![
            Self::for_test(board, misbehaving, PACKAGE, &["misbehave"], hub_motors()),
            Self::for_test(board, "hub-motors", PACKAGE, &[], hub_motors()),
            Self::for_test(board, "commission", COMMISSION, &[COMMISSION], Vec::new()),
            Self::for_test(board, "misbehaving", PACKAGE, &["misbehave"], Vec::new()),
            Self::for_test(board, "axes-8", PACKAGE, &[], many),
            Self::for_test(board, "homing", PACKAGE, &[], homing),
            Self::for_test(board, "hub-homing", PACKAGE, &[], hub_homing),
            Self::for_test(board, "shipped", PACKAGE, &[], Vec::new()),
            Self::for_test(board, LINK, PACKAGE, &[LINK], figures()),
            Self::for_test(board, LINK_USB, PACKAGE, &[LINK_USB], Vec::new()),
            Self::for_test(board, LINK_HOMING, PACKAGE, &[LINK_HOMING], figures()),
        ];
        if board == Board::Stm32f405 {
            let program = vec![(CONFIG.into(), PROGRAM.into())];
            images.push(Self::for_test(board, "program", PACKAGE, &[], program));
        }
        images
    }

    fn for_test(
        board: Board,
        name: &str,
        binary: &'static str,
        features: &[&str],
        environment: Vec<(String, String)>,
    ) -> Self {
        let mut arguments = board.arguments().to_vec();
        for feature in features {
            arguments.extend(["--features".to_owned(), (*feature).to_owned()]);
        }
        arguments.extend(["--bin".to_owned(), binary.to_owned()]);
        Self {
            name: format!("{}/{name}", board.feature()),
            binary,
            variant: Variant {
                arguments,
                environment,
            },
        }
    }

    /// The image of a board with log lines from a level on.
    pub(crate) fn of_board(board: Board, log: &str) -> Self {
        Self {
            name: format!("{}-{log}", board.feature()),
            binary: PACKAGE,
            variant: Variant {
                arguments: board.arguments().to_vec(),
                environment: vec![("DEFMT_LOG".into(), log.into())],
            },
        }
    }

    /// One with the user's configuration; `None` for `src/config.rs`.
    pub(crate) fn with_config(board: Board, config: Option<&Path>) -> Self {
        let config = config.map(|path| (CONFIG.into(), path.display().to_string()));
        Self {
            name: "emulated".into(),
            binary: PACKAGE,
            variant: Variant {
                arguments: board.arguments().to_vec(),
                environment: config.into_iter().collect(),
            },
        }
    }

    /// The one that takes orders.
    pub(crate) fn with_link(board: Board) -> Self {
        Self::with_orders(board, LINK, "info")
    }

    /// The same with log lines from a level on, or one that homes.
    pub(crate) fn with_orders(board: Board, feature: &str, log: &str) -> Self {
        let mut arguments = board.arguments().to_vec();
        arguments.extend(["--features", feature].map(String::from));
        Self {
            name: format!("{}-{feature}-{log}", board.feature()),
            binary: PACKAGE,
            variant: Variant {
                arguments,
                environment: vec![("DEFMT_LOG".into(), log.into())],
            },
        }
    }

    /// One with so many axes.
    pub(crate) fn with_axes(board: Board, axes: usize) -> Self {
        let configuration = vec![
            (CONFIG.into(), MANY_AXES.into()),
            (AXES.into(), axes.to_string()),
            // What docs/cost.md says, whatever the user's environment says.
            ("DEFMT_LOG".into(), "info".into()),
        ];
        Self {
            name: format!("{}-axes-{axes}", board.feature()),
            binary: PACKAGE,
            variant: Variant {
                arguments: board.arguments().to_vec(),
                environment: configuration,
            },
        }
    }

    /// Builds it and copies it into `folder`, because the next one takes its place among the build products.
    ///
    /// # Errors
    /// When the build or the copy fails.
    pub(crate) fn build(&self, builder: &Builder, folder: &Path) -> Result<PathBuf, Error> {
        builder.build(PACKAGE, &self.variant)?;
        let place = folder.join(&self.name);
        let copied = fs::create_dir_all(place.parent().unwrap_or(folder))
            .and_then(|()| fs::copy(builder.images().join(self.binary), &place));
        copied.map_err(|reason| Error::Image {
            path: place.clone(),
            reason: reason.to_string(),
        })?;
        Ok(place)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_boards_have_images_of_their_own() {
        let target = std::env::temp_dir().join(format!("images-{}", std::process::id()));
        fs::create_dir_all(&target).unwrap();
        let built = target.join(PACKAGE);
        let kept = Board::ALL.map(|board| {
            // As a build does: always at the same place.
            fs::write(&built, board.feature()).unwrap();
            keep_for_board(&built, board, &target).unwrap()
        });
        let read = kept.map(|path| fs::read_to_string(path).unwrap());
        let expected = Board::ALL.map(|board| board.feature().to_owned());
        fs::remove_dir_all(&target).unwrap();
        assert_eq!(read, expected);
    }
}
