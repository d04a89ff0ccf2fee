//! The functions of the library. All unsafe code is here: each function of this file gives the library what its documentation asks for.

#![allow(unsafe_code)]

use core::ffi::c_void;
use core::fmt;
use std::ffi::{CStr, OsStr};

use libloading::Library;

use crate::{Error, Message, Status};

/// The name of the library; PEAK's setup puts it into the system folder.
const NAME: &str = "PCANBasic.dll";
/// `CAN_GetErrorText` writes at most so many bytes, its end included.
const LONGEST_TEXT: usize = 256;
/// English, in the words of `CAN_GetErrorText`.
const ENGLISH: u16 = 0x09;

/// Parameters of `CAN_GetValue` and `CAN_SetValue` whose value is a `DWORD`.
#[derive(Debug, Clone, Copy)]
#[repr(u8)]
pub(crate) enum Parameter {
    ListenOnly = 0x08,
    BitsPerS = 0x1A,
}

type Initialize = unsafe extern "system" fn(u16, u16, u8, u32, u16) -> u32;
type OfChannel = unsafe extern "system" fn(u16) -> u32;
type Read = unsafe extern "system" fn(u16, *mut Message, *mut Timestamp) -> u32;
type Write = unsafe extern "system" fn(u16, *mut Message) -> u32;
type Value = unsafe extern "system" fn(u16, u8, *mut c_void, u32) -> u32;
type ErrorText = unsafe extern "system" fn(u32, u16, *mut u8) -> u32;

/// `TPCANTimestamp`.
#[derive(Default)]
#[repr(C)]
struct Timestamp {
    millis: u32,
    millis_overflow: u16,
    micros: u16,
}

/// The library, loaded.
pub struct PcanBasic {
    initialize: Initialize,
    uninitialize: OfChannel,
    get_status: OfChannel,
    read: Read,
    write: Write,
    get_value: Value,
    set_value: Value,
    error_text: ErrorText,
    /// Keeps the functions in memory.
    _library: Library,
}

impl PcanBasic {
    /// Loads the library from where PEAK's setup puts it.
    ///
    /// # Errors
    /// [`Error::NoLibrary`], [`Error::NoFunction`].
    pub fn load() -> Result<Self, Error> {
        Self::of(open_installed(), NAME)
    }

    /// Loads a library that has the same functions from a file.
    ///
    /// # Errors
    /// As [`Self::load`].
    pub fn load_from(file: impl AsRef<OsStr>) -> Result<Self, Error> {
        let file = file.as_ref();
        // SAFETY: as for `open_installed`; whoever names a file vouches for what is in it.
        let library = unsafe { Library::new(file) };
        Self::of(library, &file.to_string_lossy())
    }

    fn of(library: Result<Library, libloading::Error>, name: &str) -> Result<Self, Error> {
        let library = library.map_err(|reason| Error::NoLibrary {
            library: name.to_owned(),
            reason: cause(&reason),
        })?;
        // SAFETY: the signatures are those of PCANBasic.h, version 4; `_library` outlives the pointers, which leave this value only in
        // calls.
        unsafe {
            Ok(Self {
                initialize: function(&library, name, "CAN_Initialize")?,
                uninitialize: function(&library, name, "CAN_Uninitialize")?,
                get_status: function(&library, name, "CAN_GetStatus")?,
                read: function(&library, name, "CAN_Read")?,
                write: function(&library, name, "CAN_Write")?,
                get_value: function(&library, name, "CAN_GetValue")?,
                set_value: function(&library, name, "CAN_SetValue")?,
                error_text: function(&library, name, "CAN_GetErrorText")?,
                _library: library,
            })
        }
    }

    /// Takes a channel, with the values of the registers BTR0 and BTR1. Type, port and interrupt are of adapters without plug and play.
    pub(crate) fn initialize(&self, handle: u16, btr0_btr1: u16) -> Status {
        // SAFETY: takes numbers alone.
        Status(unsafe { (self.initialize)(handle, btr0_btr1, 0, 0, 0) })
    }

    pub(crate) fn uninitialize(&self, handle: u16) -> Status {
        // SAFETY: takes a number alone.
        Status(unsafe { (self.uninitialize)(handle) })
    }

    pub(crate) fn status(&self, handle: u16) -> Status {
        // SAFETY: takes a number alone.
        Status(unsafe { (self.get_status)(handle) })
    }

    pub(crate) fn read(&self, handle: u16) -> (Status, Message) {
        let (mut message, mut time) = (Message::default(), Timestamp::default());
        // SAFETY: both have the layout of the header and live until the call returns; the library keeps no pointer.
        let status = unsafe { (self.read)(handle, &raw mut message, &raw mut time) };
        (Status(status), message)
    }

    pub(crate) fn write(&self, handle: u16, message: &Message) -> Status {
        let mut message = *message;
        // SAFETY: as for `read`.
        Status(unsafe { (self.write)(handle, &raw mut message) })
    }

    pub(crate) fn value(&self, handle: u16, parameter: Parameter) -> Result<u32, Status> {
        let mut value = 0_u32;
        // SAFETY: each `Parameter` has a value of four bytes, which is told, and which lives until the call returns.
        let status = unsafe {
            (self.get_value)(
                handle,
                parameter as u8,
                (&raw mut value).cast(),
                size_of::<u32>() as u32,
            )
        };
        if status == Status::OK {
            Ok(value)
        } else {
            Err(Status(status))
        }
    }

    pub(crate) fn set_value(&self, handle: u16, parameter: Parameter, value: u32) -> Status {
        let mut value = value;
        // SAFETY: as for `value`.
        Status(unsafe {
            (self.set_value)(
                handle,
                parameter as u8,
                (&raw mut value).cast(),
                size_of::<u32>() as u32,
            )
        })
    }

    /// What the library says about a status.
    pub(crate) fn text(&self, status: Status) -> String {
        // One more than the library may use: there is an end in any case.
        let mut text = [0_u8; LONGEST_TEXT + 1];
        // SAFETY: the buffer has the documented size and lives until the call returns.
        let result = unsafe { (self.error_text)(status.0, ENGLISH, text.as_mut_ptr()) };
        match CStr::from_bytes_until_nul(&text) {
            Ok(text) if result == Status::OK && !text.is_empty() => {
                text.to_string_lossy().into_owned()
            }
            _ => "the library gives no reason".to_owned(),
        }
    }
}

impl fmt::Debug for PcanBasic {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.debug_struct("PcanBasic").finish_non_exhaustive()
    }
}

/// What the system says, behind what the loader says of itself.
fn cause(error: &libloading::Error) -> String {
    let of_the_system = core::error::Error::source(error);
    of_the_system.map_or_else(|| error.to_string(), ToString::to_string)
}

/// The folder of the program and that of the system alone: never the current folder.
#[cfg(windows)]
fn open_installed() -> Result<Library, libloading::Error> {
    use libloading::os::windows::{
        LOAD_LIBRARY_SEARCH_APPLICATION_DIR, LOAD_LIBRARY_SEARCH_SYSTEM32, Library as Native,
    };
    let places = LOAD_LIBRARY_SEARCH_APPLICATION_DIR | LOAD_LIBRARY_SEARCH_SYSTEM32;
    // SAFETY: whoever may write to these folders decides what this program does anyway; the library of PEAK needs nothing before it is
    // loaded.
    unsafe { Native::load_with_flags(NAME, places) }.map(Into::into)
}

/// Other systems have no library of this name.
#[cfg(not(windows))]
fn open_installed() -> Result<Library, libloading::Error> {
    // SAFETY: as on Windows, with the folders of the system's loader.
    unsafe { Library::new(NAME) }
}

/// A function of the library.
///
/// # Safety
/// `F` must be its signature, and the library must stay loaded as long as the result is called.
unsafe fn function<F: Copy>(
    library: &Library,
    library_name: &str,
    name: &'static str,
) -> Result<F, Error> {
    // SAFETY: of the caller.
    match unsafe { library.get::<F>(name) } {
        Ok(function) => Ok(*function),
        Err(_) => Err(Error::NoFunction {
            library: library_name.to_owned(),
            function: name,
        }),
    }
}
