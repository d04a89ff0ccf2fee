//! A port of this machine that no other machine reaches.

use std::net::{IpAddr, Ipv4Addr, Ipv6Addr, SocketAddr};

/// What such an address begins with.
const SCHEME: &str = "tcp:";

/// The address in a text; `None` when it does not begin as one.
///
/// # Errors
/// What was expected: other machines, and names that could be theirs, are refused.
pub(crate) fn loopback(text: &str) -> Option<Result<SocketAddr, String>> {
    let rest = text.strip_prefix(SCHEME)?;
    let (host, port) = match rest.rsplit_once(':') {
        Some((host, port)) => (host, port),
        None => ("127.0.0.1", rest),
    };
    let address = match host {
        "127.0.0.1" | "localhost" => Some(IpAddr::V4(Ipv4Addr::LOCALHOST)),
        "[::1]" => Some(IpAddr::V6(Ipv6Addr::LOCALHOST)),
        _ => None,
    };
    let Ok(port) = port.parse() else {
        return Some(Err(format!(
            "expected tcp:PORT with a port from 0 to 65535, got {text}"
        )));
    };
    Some(
        address
            .map(|address| SocketAddr::new(address, port))
            .ok_or_else(|| {
                format!(
                    "expected tcp:PORT, tcp:127.0.0.1:PORT or tcp:[::1]:PORT, got {text}: other machines are refused, because a network in between may delay what a motor waits for"
                )
            }),
    )
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn this_machine_is_meant_by_each_of_its_names() {
        for (text, expected) in [
            ("tcp:7000", "127.0.0.1:7000"),
            ("tcp:0", "127.0.0.1:0"),
            ("tcp:127.0.0.1:65535", "127.0.0.1:65535"),
            ("tcp:localhost:1", "127.0.0.1:1"),
            ("tcp:[::1]:7000", "[::1]:7000"),
        ] {
            let address = loopback(text).unwrap().unwrap();
            assert_eq!(address.to_string(), expected);
        }
    }

    #[test]
    fn another_machine_is_refused_and_so_is_what_is_no_port() {
        for text in [
            "tcp:0.0.0.0:7000",
            "tcp:[::]:7000",
            "tcp:192.168.0.7:7000",
            "tcp:127.0.0.2:7000",
            "tcp:example.org:7000",
            "tcp::7000",
        ] {
            let error = loopback(text).unwrap().unwrap_err();
            assert!(error.contains("other machines are refused"), "{error}");
        }
        for text in ["tcp:", "tcp:x", "tcp:65536", "tcp:-1", "tcp:localhost:"] {
            let error = loopback(text).unwrap().unwrap_err();
            assert!(error.contains("a port from 0 to 65535"), "{error}");
        }
    }

    #[test]
    fn anything_else_is_no_address() {
        for text in ["/dev/ttyACM0", "COM3", "tcp", "/tmp/tcp:7", "TCP:7"] {
            assert!(loopback(text).is_none(), "{text}");
        }
    }
}
