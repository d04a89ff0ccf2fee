//! Drive profile 6000h..60FFh: the guide's "CiA 402" group (section 9).

use super::entry::Access::{Ro, Rw};
use super::entry::Default::Value;
use super::entry::{Entry, entries};
use crate::object::DataType::{I8, I16, I32, U16, U32};

entries! {
    // Index, sub-index, name, type, access, mappable, default, range (of the type where none is printed), unit, doubt (Z number).
    0x603F, 0x00, "last fault code", U16, Ro, true, Value(0), None, "", Some(24);
    0x6040, 0x00, "control word", U16, Rw, true, Value(0), None, "", None;
    0x6041, 0x00, "status word", U16, Ro, true, Value(0), None, "", Some(37);
    0x605A, 0x00, "quick stop option (5, 6, 7)", I16, Rw, false, Value(5), Some((5, 7)), "", None;
    0x605B, 0x00, "shutdown option (0, 1)", I16, Rw, false, Value(1), Some((0, 1)), "", None;
    0x605C, 0x00, "disable operation option (0, 1)", I16, Rw, false, Value(1), Some((0, 1)), "", None;
    0x605D, 0x00, "halt option (0, 2, 3; default 1 is not in the list)", I16, Rw, false, Value(1), Some((0, 3)), "", Some(27);
    0x6060, 0x00, "mode of operation", I8, Rw, true, Value(0), Some((0, 6)), "", Some(4);
    0x6061, 0x00, "mode of operation display", I8, Ro, true, Value(0), None, "", Some(4);
    0x6064, 0x00, "actual position", I32, Ro, true, Value(0), None, "counts", None;
    0x606C, 0x00, "actual speed", I32, Ro, true, Value(0), None, "0.1 r/min", None;
    0x6071, 0x00, "target torque", I16, Rw, true, Value(0), Some((-30000, 30000)), "mA", Some(3);
    0x6074, 0x00, "torque demand", I16, Ro, true, Value(0), Some((-300, 300)), "mA", Some(25);
    0x6077, 0x00, "actual torque", I16, Ro, true, Value(0), Some((-30000, 30000)), "0.1 A", Some(25);
    0x607A, 0x00, "target position", I32, Rw, true, Value(0), Some((-0x7FFF_FFFF, 0x7FFF_FFFF)), "counts", Some(39);
    0x6081, 0x00, "profile speed", U32, Rw, true, Value(120), Some((1, 1000)), "r/min", Some(1);
    0x6082, 0x00, "start/stop speed", U32, Rw, true, Value(1), Some((1, 1000)), "r/min", None;
    0x6083, 0x00, "acceleration time", U32, Rw, true, Value(500), Some((0, 32767)), "ms", Some(38);
    0x6084, 0x00, "deceleration time", U32, Rw, true, Value(500), Some((0, 32767)), "ms", Some(38);
    0x6085, 0x00, "emergency stop deceleration time", U32, Rw, true, Value(10), Some((0, 32767)), "ms", Some(38);
    0x6087, 0x00, "torque slope", U32, Rw, true, Value(300), None, "mA/s", Some(26);
    0x60FF, 0x00, "target speed", I32, Rw, true, Value(0), Some((-1000, 1000)), "r/min", Some(34);
}
