"""The database of DYN CAN in cantools: what it makes of each frame is what `motionctl decode` says of it.

usage: dbc.py MOTIONCTL DATABASE
"""

import sys
import tempfile
import warnings

import cantools

import traffic
from wireshark import decoded_frames

# Signals that are the byte of what `decode` has in another form.
FORMS = {
    "enable": ("servo_switch", lambda enable: 0x00 if enable else 0xFF),
    "absolute": ("sync_kind", lambda absolute: 0xFF if absolute else 0xEE),
    "drive_error": ("drive_error", lambda error: {"data error": 0xFF, "alarm": 0xEE}.get(error)),
}
# Words beside a number that the database has.
WORDS = {"alarm", "config"}
ENVELOPE = {"kind", "time_s", "interface", "id", "extended", "remote", "data", "text", "protocol", "drive", "direction", "function",
            "response_us", "note"}


def expected_signals(frame):
    """What `decode` says, in the signals of the database; a parameter that is kept, and a line number that is not there, is 0 on the bus."""
    signals = {}
    for key, value in frame.items():
        if key in ENVELOPE | WORDS:
            continue
        if key == "bytes":
            signals.update({f"byte_{index}": byte for index, byte in enumerate(value)})
            continue
        name, form = FORMS.get(key, (key, lambda same: 0 if same is None else int(same)))
        signals[name] = form(value)
    return signals


def is_out_of_range(message, signals):
    return any(not signal.minimum <= signals[signal.name] <= signal.maximum for signal in message.signals)


class Books:
    """How many frames went which way."""

    def __init__(self):
        self.same, self.without_data, self.without_signals, self.other_order, self.other_length, self.refused = 0, 0, 0, 0, 0, 0


def check(database, frame, books, seen):
    where = f"frame {frame['id']:03X}#{frame['data']}"
    message = database.get_message_by_frame_id(frame["id"])
    if message.name.split("_", 1)[1] != frame["function"]:
        sys.exit(f"{where}: {message.name} in the database, {frame['function']} in motionctl decode")
    data = bytes.fromhex(frame["data"])
    if not message.signals:
        books.without_signals += 1
    elif not data and frame["direction"] == "to_drive":
        books.without_data += 1
    elif len(data) != message.length:
        books.other_length += 1
    elif "error" in frame:
        books.refused += 1
    else:
        signals = message.decode(data, decode_choices=False)
        expected = expected_signals(frame)
        if message.name.endswith("Read_Param_Group3") and is_out_of_range(message, signals):
            books.other_order += 1
        elif any(signals.get(name) != value for name, value in expected.items() if value is not None):
            sys.exit(f"{where}:\n  motionctl decode: {expected}\n  cantools:         {signals}")
        else:
            books.same += 1
            seen.update((frame["function"], name) for name in expected)


def main(motionctl, path):
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        database = cantools.database.load_file(path, strict=True)
    books, seen = Books(), set()
    with tempfile.TemporaryDirectory() as folder:
        for log, revision in traffic.every_kind(motionctl, folder):
            for frame in decoded_frames(motionctl, log, revision):
                if frame["protocol"] != "foreign" and frame["function"] != "ForMotorDefine":
                    check(database, frame, books, seen)
    # Set_Origin has a magic byte, which is no value of `decode`.
    signals = {(message.name.split("_", 1)[1], signal.name) for message in database.messages for signal in message.signals}
    unseen = signals - seen - {("Set_Origin", "magic")}
    if unseen:
        sys.exit(f"never compared: {sorted(unseen)}")
    print(f"cantools: {len(database.messages)} messages; {books.same} frames the same, {len(seen)} signals compared; not said by a DBC: "
          f"{books.without_signals} numbers of variable length, {books.without_data} requests without data, "
          f"{books.other_length} of another length, {books.other_order} in the other byte order, {books.refused} that do not decode")


if __name__ == "__main__":
    if len(sys.argv) != 3:
        sys.exit(__doc__)
    main(*sys.argv[1:])
