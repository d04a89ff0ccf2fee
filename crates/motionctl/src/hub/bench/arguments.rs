//! Options of `motionctl bench --drives zlac`.

use drive_sim::{BitRate, ResponseDelay, ZlacDriveConfig};
use zlac8030l::{NodeId, objects};

use crate::bench::MechanicsOptions;
use crate::host_port::Place;
use crate::hub::nodes::{Nodes, nodes};
use crate::virtual_drives::{bit_rate, percent};

const EXAMPLES: &str = "\
Examples:
  motionctl bench --drives zlac --slcan /tmp/can-adapter            one drive as it leaves the factory: node 4, 500 kbit/s
  motionctl bench --drives zlac:4,5 --slcan /tmp/can-adapter        the two wheels of a vehicle
  motionctl run --drives zlac:4,5 --slcan /tmp/can-adapter          in another terminal
  slcand -o -s6 /tmp/can-adapter can0                               as a network interface, on Linux
  motionctl bench --drives zlac:4,5 --slcan tcp:7000                on any system, for programs of this machine

The adapter speaks the Lawicel protocol and drives a virtual bus with exact bit timing, in real time. The drives answer SDO, PDO, NMT
and SYNC, and send heartbeat, boot-up and emergency messages. A drive whose stored bit rate (200Eh) is not that of the bus hears and
sends nothing from its next start on. Ctrl-C ends it and shows what each drive has received. SIGUSR1 switches the power of the drives
off and on.

Exit status: 0 ended on request, 2 the bench could not be set up, 3 the terminal failed.";

/// Options of `motionctl bench --drives zlac`.
#[derive(Debug, clap::Args)]
#[command(after_help = EXAMPLES)]
pub(in crate::hub) struct Arguments {
    /// Hub motors: zlac for node 4, zlac:NODES for others.
    #[arg(long, value_name = "zlac[:NODES]", value_parser = nodes)]
    drives: Nodes,
    /// Where programs find the CAN adapter (slcan): a link that does not exist yet, or tcp:PORT of this machine; port 0 takes one that is free.
    #[arg(long, value_name = "PATH|tcp:PORT")]
    pub(super) slcan: Place,
    /// Bit rate of the bus in kbit/s: 100, 125, 250, 500 or 1000.
    #[arg(long, value_name = "KBIT", default_value = "500", value_parser = known_bit_rate)]
    pub(super) bit_rate: BitRate,
    /// Mean response delay of the drives in microseconds.
    #[arg(long, value_name = "US", default_value_t = 200)]
    response_us: u32,
    /// Spread of the response delay around its mean in percent.
    #[arg(long, value_name = "PERCENT", default_value_t = 25, value_parser = percent)]
    response_spread: u8,
    /// Seed of the response delays.
    #[arg(long, value_name = "N", default_value_t = 1)]
    seed: u64,
    /// Speeds count 1/N r/min (202Fh:05), stored when the drive was commissioned.
    #[arg(long, value_name = "N", default_value_t = 1, value_parser = clap::value_parser!(u16).range(1..=10))]
    speed_resolution: u16,
    #[command(flatten)]
    pub(super) mechanics: MechanicsOptions,
    /// Drives that have a fault from the start, whose cause is gone: over-current.
    #[arg(long, value_name = "zlac:NODES", value_parser = nodes)]
    pub(super) alarm: Option<Nodes>,
    /// Each drive falls silent after N writes.
    #[arg(long, value_name = "N")]
    pub(super) silent_after_writes: Option<u64>,
    /// Print what the drives have received as JSON.
    #[arg(long)]
    pub(super) json: bool,
}

impl Arguments {
    /// The nodes of the drives.
    pub(super) fn nodes(&self) -> Vec<NodeId> {
        self.drives.or_factory()
    }

    /// A drive that was commissioned for this bus.
    pub(super) fn drive(&self, node: NodeId) -> ZlacDriveConfig {
        let resolution = objects::SPEED_RESOLUTION.address();
        let code = zlac8030l::BIT_RATES
            .iter()
            .position(|rate| *rate == self.bit_rate);
        let bit_rate_code = code.map(|code| (objects::CAN_BIT_RATE.address(), code as i64));
        self.mechanics.on_wheel(ZlacDriveConfig {
            response_delay: self.response_delay(),
            seed: self.seed.wrapping_add(u64::from(node.get())),
            bus_bit_rate: Some(self.bit_rate),
            stored: bit_rate_code
                .into_iter()
                .chain([(resolution, i64::from(self.speed_resolution))])
                .collect(),
            ..ZlacDriveConfig::new(node)
        })
    }

    fn response_delay(&self) -> ResponseDelay {
        let delay_ns = u64::from(self.response_us) * 1_000;
        let spread_ns = delay_ns * u64::from(self.response_spread) / 100;
        // The spread is at most the whole delay, so the least delay is not above the most.
        ResponseDelay::between(delay_ns - spread_ns, delay_ns + spread_ns)
            .unwrap_or(ResponseDelay::fixed(delay_ns))
    }
}

/// A bit rate that the drives have.
fn known_bit_rate(text: &str) -> Result<BitRate, String> {
    let rate = bit_rate(text)?;
    if zlac8030l::knows_bit_rate(rate) {
        Ok(rate)
    } else {
        Err("hub motors have 100, 125, 250, 500 and 1000 kbit/s".to_owned())
    }
}
