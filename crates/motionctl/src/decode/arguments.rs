//! Options of `motionctl decode`.

use std::path::PathBuf;

use can_decode::Meaning;
use can_decode::log::Stamps;

use crate::link::PortOptions;
use crate::revision::RevisionOption;

const EXAMPLES: &str = "\
Examples:
  motionctl decode --can can0                      while it happens, until Ctrl-C
  motionctl decode --slcan /dev/ttyACM0            the same through a serial adapter that only listens
  candump -L can0 | motionctl decode -             the same from another program
  motionctl decode run.log                         candump, with any kind of times or none
  motionctl decode trace.asc --drive 3             one drive; logs of Vector, PEAK, SavvyCAN and python-can
  motionctl decode run.log --trouble               alarms, repeated and late frames, what does not decode
  motionctl decode run.log --statistics-only       frames, intervals and response times of each identifier
  motionctl decode run.log --protocol canopen      ZLAC8030L hub motors, PDOs by the mapping that the log has
  motionctl decode run.log --report out            the motion as a page, out/index.html
  motionctl decode run.log --json | jq 'select(.alarm_code > 0)'

Which side sent a frame, and whether a reading is a position or a torque, follows from the frames
before it: begin a log before the conversation begins.

Exit status: 0 the whole log was read, 1 some lines could not be read (they are named), 2 this is no log, or
one with an unknown header, 3 the live bus cannot be opened, or has failed.";

/// Options of `motionctl decode`.
#[derive(Debug, clap::Args)]
#[command(after_help = EXAMPLES)]
pub(crate) struct Arguments {
    /// Log of candump, python-can (.log, .asc, .csv, .txt, .trc), PEAK (.trc), Vector (.asc) or SavvyCAN (.csv); `-` reads the
    /// standard input.
    #[arg(value_name = "LOG", required_unless_present_any = ["can", "slcan"])]
    pub(super) log: Option<PathBuf>,
    /// Listen to a CAN network interface instead, on Linux, or to pcan:PCAN_USBBUS1 on Windows, until Ctrl-C.
    #[arg(long, value_name = "INTERFACE", conflicts_with = "log")]
    pub(super) can: Option<String>,
    /// Listen to a Lawicel (slcan) adapter instead, until Ctrl-C; it does not even acknowledge.
    #[arg(long, value_name = "TTY", conflicts_with_all = ["log", "can"])]
    pub(super) slcan: Option<String>,
    #[command(flatten)]
    pub(super) port: PortOptions,
    /// Let the adapter acknowledge frames, where it cannot only listen. With a wrong --bit-rate it disturbs the bus.
    #[arg(long, requires = "slcan")]
    pub(super) acknowledge: bool,
    /// Show the messages of these drives only. The statistics count everything.
    #[arg(long, value_name = "ID", value_delimiter = ',', value_parser = clap::value_parser!(u8).range(0..=127))]
    drive: Vec<u8>,
    /// What the bus speaks: DYN drives and CANopen use the same identifiers.
    #[arg(long, value_enum, default_value_t)]
    pub(super) protocol: ProtocolOption,
    /// Revision of the drives. Default: as the length of their Read_Param_Group3 reply tells, 1.6A until then.
    #[arg(long, value_enum)]
    pub(super) revision: Option<RevisionOption>,
    /// Milliseconds for which a request waits for its reply.
    #[arg(long, value_name = "MS", default_value_t = 10)]
    pub(super) reply_ms: u32,
    /// What times of candump with three digits in front of the point are. Default: as their order tells.
    #[arg(long, value_enum)]
    stamps: Option<StampsOption>,
    /// Bit rate in kbit/s: for the bus load, and what a serial adapter is set to.
    #[arg(long, value_name = "KBIT", default_value_t = 1_000, value_parser = clap::value_parser!(u32).range(1..=1_000))]
    pub(super) bit_rate: u32,
    /// Show only what looks like trouble: alarms, frames that came twice, late or unasked, requests without a reply, frames
    /// that do not decode, errors on the bus.
    #[arg(long, conflicts_with = "statistics_only")]
    trouble: bool,
    /// Show no frames, only the statistics.
    #[arg(long)]
    statistics_only: bool,
    /// Write a page with pictures, DIR/index.html, of the motion that the set-points and the positions in the log tell; with
    /// several interfaces one for each in DIR/INTERFACE. Frames are shown only with --json or --trouble then.
    #[arg(long, value_name = "DIR")]
    pub(super) report: Option<PathBuf>,
    /// Write one JSON object a line: "kind" is "frame", "other" or "error", at the end "statistics" of each interface and
    /// "end".
    #[arg(long)]
    pub(super) json: bool,
}

/// What short times of candump count from.
#[derive(Debug, Clone, Copy, PartialEq, Eq, clap::ValueEnum)]
enum StampsOption {
    /// From the first frame (candump -t z).
    Zero,
    /// From the frame before (candump -t d).
    Delta,
}

/// What a bus speaks.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, clap::ValueEnum)]
pub(super) enum ProtocolOption {
    /// DYN2 and DYN4 servo drives.
    #[default]
    Dyn,
    /// ZLAC8030L hub-motor drives; --drive is a node.
    Canopen,
}

impl Arguments {
    pub(super) fn stamps(&self) -> Option<Stamps> {
        self.stamps.map(|stamps| match stamps {
            StampsOption::Zero => Stamps::Zero,
            StampsOption::Delta => Stamps::Delta,
        })
    }

    /// Whether a message is shown.
    pub(super) fn shows(&self, meaning: &Meaning) -> bool {
        let of_drive = || {
            meaning
                .drive()
                .is_some_and(|drive| self.drive.contains(&drive))
        };
        let is_page = self.report.is_some() && !self.json && !self.trouble;
        !self.statistics_only
            && !is_page
            && (self.drive.is_empty() || of_drive())
            && (!self.trouble || meaning.is_remarkable())
    }

    /// Whether what concerns the whole bus is shown.
    pub(super) fn shows_bus(&self) -> bool {
        !self.statistics_only && self.report.is_none() && self.drive.is_empty()
    }
}
