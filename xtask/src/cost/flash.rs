//! What the images of the firmware and the libraries alone take of flash and RAM.

use std::fmt::Write as _;
use std::path::Path;

use super::figure::Figure;
use crate::error::Error;
use crate::images::{Board, Image};
use crate::proofs;
use crate::size::Size;
use crate::thumb::Builder;

const OFF: &str = "off";
const LOGS: [(&str, f64); 2] = [("info", 48.0 * 1024.0), (OFF, 32.0 * 1024.0)];
const LIBRARIES_COMMAND: &str = "cargo xtask proofs";

/// What libraries should not exceed, in bytes.
const LIBRARIES: [(&str, f64); 3] = [
    (proofs::MESSAGES, 6.0 * 1024.0),
    (proofs::HOT_PAIR, 256.0),
    (proofs::ONE_AXIS, 16.0 * 1024.0),
];

/// Bytes of everything.
pub(crate) struct Flash {
    images: Vec<ImageSize>,
    libraries: Vec<(&'static str, u64)>,
}

/// One image of the firmware.
struct ImageSize {
    board: Board,
    log: &'static str,
    flash: f64,
    ram: f64,
    target: f64,
}

impl Flash {
    /// Builds the images of both boards with and without a log, and the libraries alone.
    ///
    /// # Errors
    /// When one does not build.
    pub(crate) fn measure(builder: &Builder, folder: &Path) -> Result<Self, Error> {
        let mut images = Vec::new();
        // Another log level compiles nearly everything anew: what is measured next has the first of the table.
        for log in LOGS.iter().rev() {
            for board in Board::ALL {
                images.push(ImageSize::measure(board, log, builder, folder)?);
            }
        }
        images.sort_by_key(|image: &ImageSize| image.log == OFF);
        Ok(Self {
            images,
            libraries: proofs::library_sizes(builder)?,
        })
    }

    /// The image of the default board with a log, and the libraries alone.
    ///
    /// # Errors
    /// When one does not build.
    pub(crate) fn measure_few(builder: &Builder, folder: &Path) -> Result<Self, Error> {
        let [with_log, _] = &LOGS;
        let image = ImageSize::measure(Board::Stm32f405, with_log, builder, folder)?;
        Ok(Self {
            images: vec![image],
            libraries: proofs::library_sizes(builder)?,
        })
    }

    /// Every figure, for the baseline.
    pub(crate) fn figures(&self) -> Vec<Figure> {
        let mut figures: Vec<Figure> = self.images.iter().flat_map(ImageSize::figures).collect();
        figures.extend(
            self.libraries
                .iter()
                .map(|&(image, flash)| library(image, flash)),
        );
        figures
    }

    /// What is asked for: the default board's images, and three libraries.
    pub(crate) fn targets(&self) -> Vec<Figure> {
        let default = self
            .images
            .iter()
            .filter(|image| image.board == Board::Stm32f405);
        let mut targets: Vec<Figure> = default.map(ImageSize::target).collect();
        for (image, flash) in &self.libraries {
            if let Some((_, target)) = LIBRARIES.iter().find(|(name, _)| name == image) {
                targets.push(library(image, *flash).at_most(*target));
            }
        }
        targets
    }

    /// The section of the document.
    pub(crate) fn write(&self, text: &mut String) {
        text.push_str(SECTION);
        for image in &self.images {
            // Writing to a string cannot fail.
            let _ = writeln!(
                text,
                "| {}, 2 axes, `DEFMT_LOG={}` | {} | {} | `{}` |",
                image.board.feature(),
                image.log,
                image.flash,
                image.ram,
                image.command()
            );
        }
        for (what, flash) in &self.libraries {
            let _ = writeln!(text, "| {what} | {flash} | | `{LIBRARIES_COMMAND}` |");
        }
    }
}

fn library(image: &str, flash: u64) -> Figure {
    let what = match image {
        proofs::MESSAGES => "flash of dyn-can, every request and reply, bytes".to_owned(),
        proofs::HOT_PAIR => {
            "flash of one set-point encoded and one position decoded, bytes".to_owned()
        }
        proofs::ONE_AXIS => "flash of moves, jogs and stops of one axis, bytes".to_owned(),
        other => format!("flash of the library image `{other}`, bytes"),
    };
    Figure::new(what, flash as f64, LIBRARIES_COMMAND)
}

impl ImageSize {
    fn measure(
        board: Board,
        &(log, target): &(&'static str, f64),
        builder: &Builder,
        folder: &Path,
    ) -> Result<Self, Error> {
        let image = Image::of_board(board, log).build(builder, folder)?;
        let size = Size::of_image(&image)?;
        Ok(Self {
            board,
            log,
            flash: size.flash() as f64,
            ram: size.ram() as f64,
            target,
        })
    }

    fn command(&self) -> String {
        format!(
            "DEFMT_LOG={} cargo fw --symbols --board {}",
            self.log,
            self.board.feature()
        )
    }

    fn name(&self, what: &str) -> String {
        format!(
            "{what}, {}, 2 axes, `DEFMT_LOG={}`, bytes",
            self.board.feature(),
            self.log
        )
    }

    fn target(&self) -> Figure {
        Figure::new(self.name("flash"), self.flash, self.command()).at_most(self.target)
    }

    fn figures(&self) -> [Figure; 2] {
        [
            Figure::new(self.name("flash"), self.flash, self.command()),
            Figure::new(self.name("static RAM"), self.ram, self.command()),
        ]
    }
}

const SECTION: &str = "
## Flash and RAM

Bytes. Libraries alone, every public call reachable; what an image has without the library is taken off: start-up code, and for the
images `messages` and `set-point-and-position` also the making of inputs and the use of outputs.

| image | flash | RAM | command |
|---|---|---|---|
";
