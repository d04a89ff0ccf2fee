"""The dissector for Wireshark: what tshark shows of each frame is what `motionctl decode` says of it.

usage: wireshark.py MOTIONCTL DISSECTOR

Each log is opened as it is, and as a capture file of a CAN interface.
"""

import json
import math
import re
import struct
import subprocess
import sys
import tempfile

import traffic

# What `decode --json` says of a frame beside its meaning.
ENVELOPE = {"kind", "time_s", "interface", "id", "extended", "remote", "data", "text", "protocol"}
NANOSECOND_PCAP, LINKTYPE_CAN_SOCKETCAN = 0xA1B23C4D, 227
EXTENDED, REMOTE = 0x8000_0000, 0x4000_0000
# The code that goes with each name, as the frames show it.
FUNCTION_CODES = {}
CANDUMP = re.compile(r"\((\d+)\.(\d+)\) \S+ ([0-9A-F]+)#(R?)([0-9A-F]*)$")


def fields_of(dissector):
    """The names of the fields that the dissector declares."""
    listing = tshark("-G", "fields", "-X", f"lua_script:{dissector}")
    names = [line.split("\t")[2] for line in listing.splitlines() if line.startswith("F\t")]
    return sorted(name for name in names if name.startswith("dyn.") and not name.startswith("dyn.expert."))


def tshark(*arguments):
    run = subprocess.run(["tshark", *map(str, arguments)], capture_output=True, text=True)
    trouble = [line for line in run.stderr.splitlines() if not line.startswith("Running as user")]
    if run.returncode or trouble:
        sys.exit(f"tshark {arguments}: exit status {run.returncode}, {trouble[:3]}")
    return run.stdout


def decoded_frames(motionctl, log, revision):
    """What `motionctl decode` says of each frame."""
    options = ["--revision", revision] if revision else []
    run = subprocess.run([motionctl, "decode", "--json", *options, log], capture_output=True, text=True)
    lines = [json.loads(line) for line in run.stdout.splitlines()]
    if run.returncode or any(line["kind"] == "error" for line in lines):
        sys.exit(f"{log}: exit status {run.returncode}, {run.stderr}")
    return [frame for frame in lines if frame["kind"] == "frame"]


def meaning(frame):
    """The fields that tshark shall show, without what is null."""
    if frame["protocol"] == "foreign":
        return {}
    values = {key: value for key, value in frame.items() if key not in ENVELOPE and value is not None}
    # The field is there for the broadcast address too.
    values.setdefault("drive", 0)
    return values


def dissected(dissector, log, revision, fields):
    """What tshark shows of each frame: text, or nothing."""
    options = ["-o", f"dyn.revision:{revision}"] if revision else []
    wanted = [word for field in fields for word in ("-e", field)]
    table = tshark("-X", f"lua_script:{dissector}", *options, "-r", log, "-T", "fields", "-E", "separator=/t", *wanted)
    rows = [line.split("\t") for line in table.splitlines()]
    names = [field.removeprefix("dyn.") for field in fields]
    return [{name: text for name, text in zip(names, row) if text} for row in rows]


def is_same(expected, text):
    if isinstance(expected, bool):
        return text in (("1", "True") if expected else ("0", "False"))
    if isinstance(expected, float):
        return math.isclose(expected, float(text), rel_tol=1e-9, abs_tol=1e-12)
    if isinstance(expected, list):
        return bytes(expected) == bytes.fromhex(text.replace(":", ""))
    return str(expected) == text


def compare(log, expected, actual):
    if len(expected) != len(actual):
        sys.exit(f"{log}: {len(expected)} frames in motionctl decode, {len(actual)} in tshark")
    for number, (want, got) in enumerate(zip(expected, actual), 1):
        got = dict(got)
        code = got.pop("function_code", None)
        if want and int(code, 0) != FUNCTION_CODES.setdefault(want["function"], int(code, 0)):
            sys.exit(f"{log}, frame {number}: {want['function']} has the codes {FUNCTION_CODES[want['function']]} and {code}")
        if want.keys() != got.keys() or not all(is_same(value, got[key]) for key, value in want.items()):
            sys.exit(f"{log}, frame {number}:\n  motionctl decode: {want}\n  tshark:           {got}")


def as_capture(log, path):
    """The log as a capture of a SocketCAN interface, in the file format of libpcap."""
    with open(log) as lines, open(path, "wb") as capture:
        capture.write(struct.pack("<IHHiIII", NANOSECOND_PCAP, 2, 4, 0, 0, 65535, LINKTYPE_CAN_SOCKETCAN))
        for line in lines:
            found = CANDUMP.match(line.strip())
            if not found:
                continue
            seconds, fraction, can_id, remote, data = found.groups()
            flags = (EXTENDED if len(can_id) == 8 else 0) | (REMOTE if remote else 0)
            content = b"" if remote else bytes.fromhex(data)
            count = int(data or "0", 16) if remote else len(content)
            packet = struct.pack(">IBBBB", int(can_id, 16) | flags, count, 0, 0, 0) + content
            capture.write(struct.pack("<IIII", int(seconds), int(fraction.ljust(9, "0")), len(packet), len(packet)))
            capture.write(packet)
    return path


def main(motionctl, dissector):
    fields = fields_of(dissector)
    seen = set()
    with tempfile.TemporaryDirectory() as folder:
        for log, revision in traffic.every_kind(motionctl, folder):
            expected = [meaning(frame) for frame in decoded_frames(motionctl, log, revision)]
            for file in (log, as_capture(log, f"{log}.pcap")):
                compare(file, expected, dissected(dissector, file, revision, fields))
            seen.update(key for frame in expected for key in frame)
            remarkable = sum("note" in frame or "error" in frame for frame in expected)
            print(f"{log.name}, revision {revision or 'recognised'}: {len(expected)} frames, {remarkable} remarkable, twice the same")
    unseen = {field.removeprefix("dyn.") for field in fields} - seen - {"function_code"}
    if unseen or len(FUNCTION_CODES) != 32:
        sys.exit(f"no log had these fields: {sorted(unseen)}; functions: {len(FUNCTION_CODES)} of 32")
    print(f"every one of {len(fields)} fields and of 32 functions was compared")


if __name__ == "__main__":
    if len(sys.argv) != 3:
        sys.exit(__doc__)
    main(*sys.argv[1:])
