//! A CAN driver of which anything may come.

use embedded_can::nb::Can;
use embedded_can::{Error, ErrorKind, ExtendedId, Frame, Id, StandardId};

use crate::opaque::{self, consume};

/// A driver that accepts, displaces, refuses and fails as it likes.
pub(crate) struct FakeCan;

/// A frame with any content.
#[derive(Clone, Copy)]
pub(crate) struct FakeFrame {
    id: Id,
    remote: bool,
    dlc: usize,
    data: [u8; 8],
}

/// Any error.
#[derive(Debug)]
pub(crate) struct FakeError;

impl FakeFrame {
    pub(crate) fn any() -> Self {
        let raw = opaque::word();
        let standard = StandardId::new(raw as u16).unwrap_or(StandardId::ZERO);
        let extended = ExtendedId::new(raw).unwrap_or(ExtendedId::ZERO);
        Self {
            id: opaque::pick([Id::Standard(standard), Id::Extended(extended)]),
            remote: opaque::flag(),
            dlc: opaque::word() as usize,
            data: opaque::bytes(),
        }
    }
}

impl Frame for FakeFrame {
    fn new(id: impl Into<Id>, data: &[u8]) -> Option<Self> {
        let mut frame = Self {
            id: id.into(),
            remote: false,
            dlc: data.len(),
            data: [0; 8],
        };
        for (place, byte) in frame.data.iter_mut().zip(data) {
            *place = *byte;
        }
        opaque::maybe(frame)
    }

    fn new_remote(id: impl Into<Id>, dlc: usize) -> Option<Self> {
        opaque::maybe(Self {
            id: id.into(),
            remote: true,
            dlc,
            data: [0; 8],
        })
    }

    fn is_extended(&self) -> bool {
        matches!(self.id, Id::Extended(_))
    }

    fn is_remote_frame(&self) -> bool {
        self.remote
    }

    fn id(&self) -> Id {
        self.id
    }

    fn dlc(&self) -> usize {
        self.dlc
    }

    fn data(&self) -> &[u8] {
        self.data.get(..self.dlc).unwrap_or(&self.data)
    }
}

impl Error for FakeError {
    fn kind(&self) -> ErrorKind {
        opaque::pick([
            ErrorKind::Overrun,
            ErrorKind::Bit,
            ErrorKind::Stuff,
            ErrorKind::Crc,
            ErrorKind::Form,
            ErrorKind::Acknowledge,
            ErrorKind::Other,
        ])
    }
}

impl Can for FakeCan {
    type Frame = FakeFrame;
    type Error = FakeError;

    fn transmit(&mut self, frame: &FakeFrame) -> nb::Result<Option<FakeFrame>, FakeError> {
        consume(*frame);
        match opaque::word() {
            0 => Err(nb::Error::WouldBlock),
            1 => Err(nb::Error::Other(FakeError)),
            _ => Ok(opaque::maybe(FakeFrame::any())),
        }
    }

    fn receive(&mut self) -> nb::Result<FakeFrame, FakeError> {
        match opaque::word() {
            0 => Err(nb::Error::WouldBlock),
            1 => Err(nb::Error::Other(FakeError)),
            _ => Ok(FakeFrame::any()),
        }
    }
}
