"""MCAP files of `motionctl sim` and `motionctl run`, read by the Python package mcap.

Usage: mcap_recording.py MOTIONCTL

Every cycle and every frame must be there, each message must satisfy the schema of its channel, and the numbers must be those of the
table and of the log of the same motion.
"""

import csv
import json
import os
import signal
import subprocess
import sys
import tempfile
import time
from collections import defaultdict

import fastjsonschema
from mcap.reader import make_reader

PATIENCE_S = 30
MOTION = "time_s,x_deg,y_mm\n0,10,0\n0.5,180,-9\n1,370,-18\n"
SCALE = ["--mm-per-turn", "-,36"]


def main(tool):
    with tempfile.TemporaryDirectory() as folder:
        motion = os.path.join(folder, "motion.csv")
        with open(motion, "w", encoding="ascii") as file:
            file.write(MOTION)
        check("sim", *record([tool, "sim", "--trajectory", motion, *SCALE], folder, "sim"))
        adapter = os.path.join(folder, "adapter")
        bench = subprocess.Popen(
            [tool, "bench", "--drives", "1,2", "--slcan", adapter, "--json"],
            stdout=subprocess.PIPE,
        )
        try:
            await_path(adapter)
            command = [tool, "run", "--slcan", adapter, "--trajectory", motion, "--yes", *SCALE]
            check("run", *record(command, folder, "run"))
        finally:
            bench.send_signal(signal.SIGINT)
            bench.communicate(timeout=PATIENCE_S)


def await_path(path):
    start = time.monotonic()
    while not os.path.exists(path):
        assert time.monotonic() - start < PATIENCE_S, f"no {path}"
        time.sleep(0.02)


def record(command, folder, name):
    """Runs the tool with everything recorded; the result is its summary and the files."""
    path = {kind: os.path.join(folder, f"{name}.{kind}") for kind in ("mcap", "csv", "log")}
    files = ["--mcap", path["mcap"], "--csv", path["csv"], "--candump", path["log"]]
    done = subprocess.run([*command, *files, "--json"], stdout=subprocess.PIPE, check=True)
    return json.loads(done.stdout), path


def check(name, summary, path):
    by_topic, validators = defaultdict(list), {}
    with open(path["mcap"], "rb") as file:
        reader = make_reader(file, validate_crcs=True)
        metadata = {entry.name: entry.metadata for entry in reader.iter_metadata()}
        for schema, channel, message in reader.iter_messages(log_time_order=False):
            assert schema is not None and schema.encoding == "jsonschema", channel.topic
            assert channel.message_encoding == "json", channel.topic
            if schema.id not in validators:
                validators[schema.id] = fastjsonschema.compile(json.loads(schema.data))
            value = json.loads(message.data)
            validators[schema.id](value)
            by_topic[channel.topic].append((channel, message, value))
        statistics = reader.get_summary().statistics
    count = {topic: len(messages) for topic, messages in by_topic.items()}
    assert sum(count.values()) == statistics.message_count, "the file counts its messages"

    recording = summary["recording"]
    for topic in ("/cycle", "/axis/x_deg", "/axis/y_mm"):
        assert count[topic] == recording["cycles"], (topic, count[topic], recording)
    assert count["/frames"] == recording["frames"], (count["/frames"], recording)
    for file in recording["files"]:
        assert file["stopped"] is None and file["lost"] == {"cycles": 0, "frames": 0}, file
    check_cycles(by_topic, path["csv"])
    check_frames(by_topic["/frames"], path["log"])
    check_units(by_topic["/axis/y_mm"])
    facts = metadata["motionctl"]
    assert "--mcap" in facts["command line"] and "UTC" in facts["date"], facts
    print(f"{name}: {count} messages, every one by its schema")


def check_cycles(by_topic, table):
    with open(table, newline="", encoding="utf-8") as file:
        rows = list(csv.DictReader(file))
    assert len(rows) == len(by_topic["/cycle"])
    numbers = [value["number"] for _, _, value in by_topic["/cycle"]]
    assert numbers == sorted(set(numbers)), "cycles in their order, each once"
    for drive, topic in ((1, "/axis/x_deg"), (2, "/axis/y_mm")):
        for row, (_, message, value) in zip(rows, by_topic[topic]):
            for column, field in (
                ("target_counts", "target_counts"),
                ("sent_counts", "sent_counts"),
                ("drive_counts", "position_counts"),
                ("error_counts", "following_error_counts"),
            ):
                text = row[f"drive{drive}_{column}"]
                expected = int(text) if text else None
                assert value.get(field) == expected, (topic, field, value, row)
            assert value["state"] == row[f"drive{drive}_state"]
            assert message.log_time > 1_600_000_000 * 10**9, "times count from 1970"


def check_frames(messages, log):
    with open(log, encoding="ascii") as file:
        lines = [line.split()[2] for line in file]
    frames = [f"{value['id']:03X}#{value['data']}" for _, _, value in messages]
    assert frames == lines, "the same frames in the same order"
    texts = {value["text"].split(":")[0].split()[-1] for _, _, value in messages}
    assert "Go_Relative_Pos_PD" in texts, texts


def check_units(messages):
    channel = messages[0][0]
    assert channel.metadata["unit"] == "mm" and channel.metadata["drive"] == "2", channel.metadata
    # 36 mm a turn of 16384 counts: the motion ends half a turn back.
    first, last = messages[0][2], messages[-1][2]
    assert abs((last["sent"] - first["sent"]) + 18) < 1e-3, (first, last)
    way = last["sent_counts"] - first["sent_counts"]
    assert way == -8192, way


if __name__ == "__main__":
    main(*sys.argv[1:])
