//! What the cycle tells the thread: words that the cycle alone writes, but for those that the thread asks with.

use core::sync::atomic::{AtomicBool, AtomicI32, AtomicU8, AtomicU16, AtomicU32, Ordering};

use board_link::board::Machine;
#[cfg(feature = "link-homing")]
use board_link::message::Origin;
use board_link::message::{AxisSnapshot, BoardState};

use crate::config::AXES;
use crate::machine;

/// One axis.
struct OfAxis {
    target: AtomicI32,
    position: AtomicI32,
    error: AtomicI32,
    fault: AtomicU16,
    #[cfg(feature = "link-homing")]
    origin: Origins,
}

/// What an axis counts from.
#[cfg(feature = "link-homing")]
struct Origins {
    counts: AtomicI32,
    uncertainty: AtomicU32,
}

/// The machine as the cycle has told it last.
pub(crate) struct Shared {
    state: AtomicU8,
    late_cycles: AtomicU32,
    /// Changes with every write of the cycle, so that the thread sees that it was interrupted by one.
    writes: AtomicU32,
    /// The axes that the thread wants to know about, a bit each. The cycle tells one of them at a time.
    wanted: AtomicU32,
    axes: [OfAxis; AXES],
    /// The axes whose origins are known, a bit each.
    #[cfg(feature = "link-homing")]
    known: AtomicU16,
    /// The thread stores settings: nothing is enabled meanwhile.
    is_storing: AtomicBool,
}

pub(crate) static SHARED: Shared = Shared {
    state: AtomicU8::new(BoardState::NoSettings as u8),
    late_cycles: AtomicU32::new(0),
    writes: AtomicU32::new(0),
    wanted: AtomicU32::new(0),
    axes: [const {
        OfAxis {
            target: AtomicI32::new(0),
            position: AtomicI32::new(0),
            error: AtomicI32::new(0),
            fault: AtomicU16::new(0),
            #[cfg(feature = "link-homing")]
            origin: Origins {
                counts: AtomicI32::new(0),
                uncertainty: AtomicU32::new(0),
            },
        }
    }; AXES],
    #[cfg(feature = "link-homing")]
    known: AtomicU16::new(0),
    is_storing: AtomicBool::new(false),
};

/// For the cycle.
impl Shared {
    pub(crate) fn set_state(&self, state: BoardState) {
        self.state.store(state as u8, Ordering::Relaxed);
    }

    pub(crate) fn set_late_cycles(&self, cycles: u32) {
        self.late_cycles.store(cycles, Ordering::Relaxed);
    }

    /// An axis that the thread wants to know about; it counts as told then.
    pub(crate) fn take_wanted(&self) -> Option<usize> {
        let wanted = self.wanted.load(Ordering::Relaxed);
        if wanted == 0 {
            return None;
        }
        self.wanted.store(wanted & (wanted - 1), Ordering::Relaxed);
        Some(wanted.trailing_zeros() as usize)
    }

    /// Where the set-point of an axis stands.
    pub(crate) fn set_target(&self, axis: usize, target: i32) {
        if let Some(axis) = self.axes.get(axis) {
            axis.target.store(target, Ordering::Relaxed);
            self.note_write();
        }
    }

    pub(crate) fn set_axis(&self, axis: usize, snapshot: &AxisSnapshot) {
        if let Some(axis) = self.axes.get(axis) {
            axis.target.store(snapshot.target, Ordering::Relaxed);
            axis.position.store(snapshot.position, Ordering::Relaxed);
            axis.error.store(snapshot.error, Ordering::Relaxed);
            axis.fault.store(snapshot.fault, Ordering::Relaxed);
            self.note_write();
        }
    }

    /// What an axis counts from, as its homing has found.
    #[cfg(feature = "link-homing")]
    pub(crate) fn set_origin(&self, axis: usize, counts: i32, uncertainty: u32) {
        if let Some(of) = self.axes.get(axis) {
            of.origin.counts.store(counts, Ordering::Relaxed);
            of.origin.uncertainty.store(uncertainty, Ordering::Relaxed);
            let known = self.known.load(Ordering::Relaxed) | 1 << axis;
            self.known.store(known, Ordering::Relaxed);
            self.note_write();
        }
    }

    /// None is known.
    #[cfg(feature = "link-homing")]
    pub(crate) fn forget_origins(&self) {
        self.known.store(0, Ordering::Relaxed);
        self.note_write();
    }

    fn note_write(&self) {
        let writes = self.writes.load(Ordering::Relaxed);
        self.writes.store(writes.wrapping_add(1), Ordering::Release);
    }

    pub(crate) fn is_storing(&self) -> bool {
        self.is_storing.load(Ordering::Acquire)
    }
}

/// For the thread.
impl Shared {
    pub(crate) fn state(&self) -> BoardState {
        let number = self.state.load(Ordering::Relaxed);
        BoardState::with_number(number.into()).unwrap_or_default()
    }

    pub(crate) fn set_storing(&self, is_storing: bool) {
        self.is_storing.store(is_storing, Ordering::Release);
    }

    /// Asks for every axis.
    pub(crate) fn want_axes(&self) {
        let all = (1_u32 << machine::axes().len()) - 1;
        self.wanted.fetch_or(all, Ordering::Relaxed);
    }

    /// The axes whose origins are known, a bit each.
    #[cfg(feature = "link-homing")]
    pub(crate) fn known(&self) -> u16 {
        self.known.load(Ordering::Relaxed)
    }

    /// What an axis counts from.
    #[cfg(feature = "link-homing")]
    pub(crate) fn origin(&self, axis: usize) -> Origin {
        let homing = machine::get().and_then(|machine| machine.homings.get(axis)?.as_ref());
        let Some(of) = self.axes.get(axis).filter(|_| homing.is_some()) else {
            return Origin::OfDrive;
        };
        self.at_once(|| {
            if self.known() >> axis & 1 == 0 {
                Origin::Unknown
            } else {
                Origin::Found {
                    counts: of.origin.counts.load(Ordering::Relaxed),
                    uncertainty: of.origin.uncertainty.load(Ordering::Relaxed),
                }
            }
        })
    }

    /// Everything that was told.
    pub(crate) fn read(&self) -> Machine {
        self.at_once(|| Machine {
            state: self.state(),
            axes: self
                .axes
                .iter()
                .take(machine::axes().len())
                .map(OfAxis::read)
                .collect(),
            late_cycles: self.late_cycles.load(Ordering::Relaxed),
        })
    }

    /// What belongs together. The interrupt of the cycle may come in between: then it is read anew.
    fn at_once<T>(&self, read: impl Fn() -> T) -> T {
        loop {
            let writes = self.writes.load(Ordering::Acquire);
            let all = read();
            if self.writes.load(Ordering::Acquire) == writes {
                return all;
            }
        }
    }
}

impl OfAxis {
    fn read(&self) -> AxisSnapshot {
        AxisSnapshot {
            target: self.target.load(Ordering::Relaxed),
            position: self.position.load(Ordering::Relaxed),
            error: self.error.load(Ordering::Relaxed),
            fault: self.fault.load(Ordering::Relaxed),
        }
    }
}
