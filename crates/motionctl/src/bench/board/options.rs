//! The options that say what board is on the bus.

use std::path::PathBuf;

use crate::host_port::Place;

/// A motion board on the bus.
#[derive(Debug, clap::Args)]
pub(crate) struct BoardOptions {
    /// Where programs find the serial port of a motion board that is on the bus, too: a link that does not exist yet, or tcp:PORT of this
    /// machine.
    #[arg(long, value_name = "PATH|tcp:PORT")]
    pub(in crate::bench) board: Option<Place>,
    /// File with the settings of the board, which it writes, too: its flash. Without it they are lost at the end.
    #[arg(long, value_name = "FILE.toml", requires = "board")]
    pub(super) settings: Option<PathBuf>,
    /// The stop circuit is open at the start.
    #[arg(long, requires = "board")]
    pub(super) stop_open: bool,
    /// The enable input is inactive at the start.
    #[arg(long, requires = "board")]
    pub(super) enable_inactive: bool,
    /// Take lines on standard input: "stop open", "stop closed", "enable inactive", "enable active", "reset" of the board.
    #[arg(long, requires = "board")]
    pub(super) inputs: bool,
}
