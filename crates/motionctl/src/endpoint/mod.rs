//! Where other programs reach this one: a port or a socket file, on this machine only unless told otherwise.

mod lines;
mod listener;

use core::fmt;
use core::str::FromStr;
use std::io;
use std::net::{IpAddr, Ipv4Addr, SocketAddr, ToSocketAddrs};
use std::path::PathBuf;

pub(crate) use lines::{LONGEST_LINE, Line, LineReader};
pub(crate) use listener::{Door, Listener, Peer};

/// Where to listen.
#[derive(Debug, Clone, PartialEq, Eq)]
pub(crate) enum Endpoint {
    /// Standard input.
    StandardInput,
    /// A TCP port of this machine, or of one of its addresses.
    Tcp { host: Option<String>, port: u16 },
    /// A socket file.
    Unix(PathBuf),
}

/// Why nobody can be listened to.
#[derive(Debug)]
pub(crate) enum EndpointError {
    /// Other machines would reach it, and nobody said that they may.
    Remote { host: String },
    /// The name of a host that has no address.
    NoAddress { host: String },
    /// There is something at the path that is no socket.
    NoSocket { path: PathBuf },
    /// Another program listens there.
    InUse { endpoint: String },
    /// It cannot be opened.
    Open { endpoint: String, source: io::Error },
}

impl fmt::Display for EndpointError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Remote { host } => write!(
                f,
                "tcp:{host}: other machines could move these axes: expected tcp:PORT, which only programs of this machine reach, or --allow-remote"
            ),
            Self::NoAddress { host } => write!(f, "tcp:{host}: this host has no address"),
            Self::NoSocket { path } => write!(
                f,
                "unix:{0}: expected no file or an unused socket, got another kind of file: remove it or choose another path",
                path.display()
            ),
            Self::InUse { endpoint } => {
                write!(f, "{endpoint}: another program listens there already")
            }
            Self::Open { endpoint, source } => write!(f, "cannot listen at {endpoint}: {source}"),
        }
    }
}

impl std::error::Error for EndpointError {}

impl fmt::Display for Endpoint {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::StandardInput => f.write_str("-"),
            Self::Tcp { host: None, port } => write!(f, "tcp:{port}"),
            Self::Tcp {
                host: Some(host),
                port,
            } => write!(f, "tcp:{host}:{port}"),
            Self::Unix(path) => write!(f, "unix:{}", path.display()),
        }
    }
}

impl FromStr for Endpoint {
    type Err = String;

    fn from_str(text: &str) -> Result<Self, String> {
        let expected = || format!("expected -, tcp:PORT, tcp:HOST:PORT or unix:PATH, got {text}");
        if text == "-" {
            return Ok(Self::StandardInput);
        }
        match text.split_once(':') {
            Some(("unix", path)) if !path.is_empty() => Ok(Self::Unix(path.into())),
            Some(("tcp", rest)) => {
                let (host, port) = match rest.rsplit_once(':') {
                    Some((host, port)) => (Some(host.to_owned()), port),
                    None => (None, rest),
                };
                let port = port.parse().map_err(|_| expected())?;
                if host.as_ref().is_some_and(String::is_empty) {
                    return Err(expected());
                }
                Ok(Self::Tcp { host, port })
            }
            _ => Err(expected()),
        }
    }
}

/// The address of a port; one that other machines reach only when that is allowed.
fn address(host: Option<&str>, port: u16, allow_remote: bool) -> Result<SocketAddr, EndpointError> {
    let Some(host) = host else {
        return Ok(SocketAddr::new(IpAddr::V4(Ipv4Addr::LOCALHOST), port));
    };
    let bare = host.trim_start_matches('[').trim_end_matches(']');
    let mut addresses = (bare, port).to_socket_addrs().ok().into_iter().flatten();
    let Some(address) = addresses.next() else {
        return Err(EndpointError::NoAddress { host: host.into() });
    };
    if !address.ip().is_loopback() && !allow_remote {
        return Err(EndpointError::Remote { host: host.into() });
    }
    Ok(address)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_an_endpoint_is() {
        for text in [
            "-",
            "tcp:7001",
            "tcp:localhost:7001",
            "tcp:[::1]:7",
            "unix:/tmp/a:b",
        ] {
            let endpoint: Endpoint = text.parse().unwrap();
            assert_eq!(endpoint.to_string(), text);
        }
        for text in [
            "",
            "tcp:",
            "tcp:a",
            "tcp:70000",
            "tcp::7",
            "unix:",
            "udp:7",
            "/tmp/a",
        ] {
            let error = text.parse::<Endpoint>().unwrap_err();
            assert!(error.contains("expected -, tcp:PORT"), "{error}");
        }
    }

    #[test]
    fn other_machines_are_let_in_by_an_option_alone() {
        assert!(address(None, 1, false).unwrap().ip().is_loopback());
        assert!(address(Some("127.0.0.1"), 1, false).is_ok());
        assert!(address(Some("[::1]"), 1, false).is_ok());
        let error = address(Some("0.0.0.0"), 1, false).unwrap_err();
        assert!(error.to_string().contains("--allow-remote"), "{error}");
        assert!(address(Some("0.0.0.0"), 1, true).is_ok());
    }
}
