//! The option that says which board.

/// What the boards' serial ports are set to; ports on USB ignore it.
pub(super) const BAUD: u32 = 921_600;

/// Which board.
#[derive(Debug, Clone, clap::Args)]
pub(super) struct PortOptions {
    /// Serial port of the board (COM3 on Windows), or terminal or tcp:PORT of `motionctl bench --board`.
    #[arg(long, value_name = "TTY|tcp:PORT")]
    pub(super) port: String,
    /// Speed of the serial port in baud; USB CDC ignores it.
    #[arg(long, value_name = "BAUD", default_value_t = BAUD, value_parser = clap::value_parser!(u32).range(300..=12_000_000))]
    pub(super) baud: u32,
}
