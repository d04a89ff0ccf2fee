//! The SDO client of node 4 behind lines. Its time passes only by command, so that a run does not depend on the machine.
//!
//! | Command | Meaning |
//! |---|---|
//! | `read INDEX SUB` | start a read; the request goes out as a frame, or `!busy` says why not |
//! | `write INDEX SUB BYTES VALUE` | start a write of so many bytes, all in hexadecimal digits |
//! | `pass US` | let so many microseconds pass |
//! | `tolerate` | accept the guide's wrong confirmation of 6081h from now on |
//!
//! `!end value BYTES VALUE`, `!end written`, `!end aborted CODE`, `!end timed-out` and `!end specifier CS` tell how a transfer
//! ended, `!ignored WHY` that a frame was not believed.

use std::io::{self, BufRead, Write};

use zlac8030l::{
    DataFrame, NodeId, ObjectAddress, ObjectData, SdoBusy, SdoClient, SdoEnd, SdoEvent, SdoHeard,
    SdoIgnored, SdoQuirks, SdoRequest, SdoTimeouts,
};

use super::{frame, hex};

/// Serves lines until standard input ends.
///
/// # Errors
/// When standard input cannot be read or standard output is closed.
pub fn run() -> io::Result<()> {
    let mut bridge = Bridge {
        client: SdoClient::new(NodeId::FACTORY, SdoTimeouts::DEFAULT),
        now_us: 0,
        out: io::stdout(),
    };
    for line in io::stdin().lock().lines() {
        let line = line?;
        match frame(&line) {
            Some(frame) => bridge.hear(&frame)?,
            None => bridge.obey(&line)?,
        }
        bridge.out.flush()?;
    }
    Ok(())
}

struct Bridge<W> {
    client: SdoClient,
    now_us: u64,
    out: W,
}

impl<W: Write> Bridge<W> {
    fn hear(&mut self, frame: &DataFrame) -> io::Result<()> {
        match self.client.on_frame(self.now_us, frame) {
            SdoHeard::Ended(event) => self.tell_end(event),
            SdoHeard::Ignored(reason) => writeln!(self.out, "!ignored {}", word(reason)),
        }
    }

    fn obey(&mut self, line: &str) -> io::Result<()> {
        let words: Vec<&str> = line.split_whitespace().collect();
        match words[..] {
            ["read", index, sub] => match address(index, sub) {
                Some(address) => self.start(SdoRequest::Read(address))?,
                None => writeln!(self.out, "!error")?,
            },
            ["write", index, sub, bytes, value] => match write(index, sub, bytes, value) {
                Some(request) => self.start(request)?,
                None => writeln!(self.out, "!error")?,
            },
            ["pass", us] => {
                self.now_us += us.parse::<u64>().unwrap_or_default();
                if let Some(event) = self.client.poll(self.now_us) {
                    self.tell_end(event)?;
                }
            }
            ["tolerate"] => {
                self.client = self.client.with_quirks(SdoQuirks {
                    profile_speed_confirmed_as_sub_1: true,
                });
            }
            _ => writeln!(self.out, "!error")?,
        }
        writeln!(self.out, "!done")
    }

    fn start(&mut self, request: SdoRequest) -> io::Result<()> {
        match self.client.start(self.now_us, request) {
            Ok(frame) => writeln!(self.out, "{frame}"),
            Err(SdoBusy::Running { .. }) => writeln!(self.out, "!busy running"),
            Err(SdoBusy::Quarantined { .. }) => writeln!(self.out, "!busy quarantined"),
            Err(SdoBusy::Settling { .. }) => writeln!(self.out, "!busy settling"),
            Err(_) => writeln!(self.out, "!error"),
        }
    }

    fn tell_end(&mut self, event: SdoEvent) -> io::Result<()> {
        match event.end {
            SdoEnd::Value(data) => {
                writeln!(self.out, "!end value {} {:X}", data.len(), data.raw())?;
            }
            SdoEnd::Written => writeln!(self.out, "!end written")?,
            SdoEnd::Aborted(code) => writeln!(self.out, "!end aborted {:08X}", code.get())?,
            SdoEnd::TimedOut => writeln!(self.out, "!end timed-out")?,
            SdoEnd::Specifier { actual } => writeln!(self.out, "!end specifier {actual:02X}")?,
        }
        match event.abort() {
            Some(abort) => writeln!(self.out, "{}", abort.encode(self.client.node())),
            None => Ok(()),
        }
    }
}

fn address(index: &str, sub: &str) -> Option<ObjectAddress> {
    Some(ObjectAddress::new(hex(index)?, hex(sub)?))
}

fn write(index: &str, sub: &str, bytes: &str, value: &str) -> Option<SdoRequest> {
    let value: u32 = hex(value)?;
    let bytes: u8 = hex(bytes)?;
    let data = ObjectData::from_bytes(value.to_le_bytes().get(..usize::from(bytes))?)?;
    Some(SdoRequest::Write(address(index, sub)?, data))
}

fn word(reason: SdoIgnored) -> &'static str {
    match reason {
        SdoIgnored::Foreign => "foreign",
        SdoIgnored::Unawaited { .. } => "unawaited",
        SdoIgnored::Address { .. } => "address",
        SdoIgnored::Direction => "direction",
        SdoIgnored::Malformed(_) => "malformed",
        _ => "otherwise",
    }
}
