//! Options that say who else may give orders.

use std::io;

use super::keys::HELP;
use super::{ControlSocket, Keys, Wishes};
use crate::endpoint::{Endpoint, EndpointError};

/// Who may give orders to a motion.
#[derive(Debug, Clone, clap::Args)]
pub(crate) struct ControlOptions {
    /// Take orders at a socket while the motion runs, one a line: pause, resume, override PERCENT (0 to 200), stop, status. unix:PATH or
    /// tcp:PORT, see docs/stream.md.
    #[arg(long, value_name = "ENDPOINT")]
    control: Option<Endpoint>,
    /// Let programs on other machines stream and give orders, with tcp:HOST:PORT. They can move the axes.
    #[arg(long)]
    pub(crate) allow_remote: bool,
}

/// Those who give orders, as long as it is held.
pub(crate) struct Listening {
    _socket: Option<ControlSocket>,
    keys: Option<Keys>,
}

impl ControlOptions {
    /// Opens the socket; nothing is obeyed yet.
    ///
    /// # Errors
    /// [`EndpointError`].
    pub(crate) fn open(&self, wishes: &Wishes) -> Result<Option<ControlSocket>, EndpointError> {
        let open = |endpoint| ControlSocket::open(endpoint, self.allow_remote, wishes);
        self.control.as_ref().map(open).transpose()
    }
}

impl Listening {
    /// With the keys of the terminal, where there is one in front of which somebody sits.
    ///
    /// # Errors
    /// When the terminal cannot be set up.
    pub(crate) fn new(
        socket: Option<ControlSocket>,
        wishes: &Wishes,
        takes_keys: bool,
    ) -> io::Result<Self> {
        let keys = if takes_keys {
            Keys::open(wishes.sender())?
        } else {
            None
        };
        Ok(Self {
            _socket: socket,
            keys,
        })
    }

    /// What the keys are, when there are any.
    pub(crate) fn help(&self) -> Option<&'static str> {
        self.keys.as_ref().map(|_| HELP)
    }
}
