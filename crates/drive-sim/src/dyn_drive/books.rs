//! What a drive has accepted, refused and sent: exact books for tests.
//!
//! Specification: the books count since the drive was made. No power cycle, alarm, origin or wrap of a register changes what is in them.

/// Exact books of one drive.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
#[non_exhaustive]
pub struct Books {
    /// Sum of all Go_Relative_Pos_PD steps that were accepted, in command counts.
    pub commanded_counts: i64,
    /// Go_Relative_Pos_PD frames that were accepted.
    pub pd_frames: u64,
    /// Go_Relative_Pos_PD frames with a valid step that were ignored: servo off, alarm, or another mode.
    pub pd_frames_ignored: u64,
    /// Built-in moves that were started, by Sync_Trigger too.
    pub moves: u64,
    /// Sum of the distances of all relative built-in moves that were started, in command counts.
    pub relative_move_counts: i64,
    /// Target of the last built-in move in command counts, in the drive's coordinates of that moment.
    pub last_move_target_counts: Option<i64>,
    /// Motion commands other than Go_Relative_Pos_PD that were ignored: servo off, alarm, another mode, nothing loaded.
    pub moves_ignored: u64,
    /// Frames to this drive that do not decode as a request.
    pub undecodable_frames: u64,
    /// Frames with the factory's function code 0x0F, which nobody may send.
    pub factory_frames: u64,
    /// Packets to this drive over its serial port that are a request.
    pub serial_requests: u64,
    /// Packets to this drive over its serial port that are none, or that ask to store what cannot be stored.
    pub undecodable_packets: u64,
    /// Replies over the serial port that were prepared, dropped ones included.
    pub serial_replies: u64,
    /// Replies that were prepared, dropped ones included.
    pub replies: u64,
    /// Data errors that were prepared.
    pub data_errors: u64,
    /// Alarm frames that were prepared.
    pub alarm_frames: u64,
    /// Frames that a fault kept from the bus: dropped replies and everything while silent.
    pub unsent_frames: u64,
}
