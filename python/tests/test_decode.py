"""Logs into words and values, and compared with the tool."""

from __future__ import annotations

import json
from pathlib import Path
from typing import Any, Callable, Dict, List

import pytest

from motion_board import CodecError, Decoder, Frame, InputError, LogError, canopen, decode, dyn_can

LOG = """\
(0.162046) can0 029#
(0.162667) can0 029#00
(0.862056) can0 03C#01
(0.862114) can0 02E#1B
(0.862763) can0 02E#29
(0.900000) can0 03D#EE
"""


def test_a_log_is_words_and_values() -> None:
    lines = list(decode(LOG.splitlines()))
    assert [line["line"] for line in lines] == [1, 2, 3, 4, 5, 6]
    assert lines[4]["text"] == "from drive 1  General_Read: position 41 counts (0.649 ms after the request)"
    assert lines[4]["position_counts"] == 41 and lines[4]["response_us"] == pytest.approx(649)
    assert lines[2]["step_counts"] == 1 and lines[2]["direction"] == "to_drive"
    assert lines[5]["drive_error"] == "alarm"
    assert (lines[0]["time_s"], lines[0]["interface"], lines[0]["data"]) == (0.162046, "can0", "")


def test_a_line_that_cannot_be_read_has_file_line_and_column(tmp_path: Path) -> None:
    log = tmp_path / "run.log"
    log.write_text(LOG.replace("03C#01", "03C#0G"))
    with pytest.raises(LogError) as caught:
        list(decode(log))
    error = caught.value
    assert (error.file, error.line, error.column) == (str(log), 3, 21)
    assert str(error).startswith(f"{log}:3:21: expected ")
    assert '"0G"' in error.reason
    kept = list(decode(log, errors="yield"))
    assert [line["kind"] for line in kept] == ["frame", "frame", "error", "frame", "frame", "frame"]
    assert kept[2]["line"] == 3 and kept[2]["column"] == 21


def test_what_is_no_log_is_refused_whatever_errors_are(tmp_path: Path) -> None:
    binary = tmp_path / "run.blf"
    binary.write_bytes(b"LOGG\x90\0\0")
    prose = tmp_path / "notes.txt"
    prose.write_text("this\nis\nno\nlog\nat\nall\n")
    for path, line in ((binary, 1), (prose, 5)):
        with pytest.raises(LogError) as caught:
            list(decode(path, errors="yield"))
        assert (caught.value.file, caught.value.line) == (str(path), line)
    with pytest.raises(FileNotFoundError):
        decode(tmp_path / "missing.log")
    with pytest.raises(InputError, match="errors: expected"):
        decode(LOG.splitlines(), errors="ignore")
    with pytest.raises(InputError, match="protocol: expected dyn or canopen, got modbus"):
        list(decode(LOG.splitlines(), protocol="modbus"))


def test_a_time_that_goes_back_and_a_line_without_end_are_named(tmp_path: Path) -> None:
    lines = list(decode(["(2.0) can0 029#", "(1.0) can0 029#"], errors="yield"))
    assert [line["kind"] for line in lines] == ["frame", "error", "frame"]
    assert "goes back from 2.000000 s to 1.000000 s" in lines[1]["error"]
    log = tmp_path / "run.log"
    log.write_text("(1.0) can0 029#\n" + "7" * 1_000_000 + "\n(2.0) can0 029#\n")
    kinds = [(line["kind"], line["line"]) for line in decode(log, errors="yield")]
    assert kinds == [("frame", 1), ("error", 2), ("frame", 3)]


def test_frames_are_followed_one_by_one() -> None:
    decoder = Decoder()
    assert decoder.hear(dyn_can.encode_request("General_Read", 3, reads="torque"), 1.0)["reads"] == "torque"
    said = decoder.hear(Frame(0x06E, b"\x64"), 1.0005)
    assert said["torque"] == 100 and said["response_us"] == pytest.approx(500)
    assert Decoder("canopen").hear(canopen.sync())["service"] == "SYNC"
    assert decoder.hear(Frame(0x1234567, b"", extended=True))["protocol"] == "foreign"
    with pytest.raises(CodecError, match="at most 8 bytes"):
        decoder.hear(Frame(1, bytes(9)))
    with pytest.raises(CodecError, match="id: expected 0 to 2047, got 2048"):
        decoder.hear(Frame(0x800))
    with pytest.raises(InputError, match="time_s"):
        decoder.hear(Frame(1), float("nan"))


DELTAS = [f" (000.{us:06d})  can0  03C   [1]  88\n" for us in (0, 10_000, 2_000, 500, 20_000, 1_000)]


def test_differences_are_told_in_lists_and_files_as_behind_a_path(tmp_path: Path) -> None:
    log = tmp_path / "delta.log"
    log.write_text("".join(DELTAS))
    times = [line["time_s"] for line in decode(log)]
    assert times == pytest.approx([0, 0.01, 0.012, 0.0125, 0.0325, 0.0335])
    assert [line["time_s"] for line in decode(DELTAS)] == times
    assert [line["time_s"] for line in decode(tuple(DELTAS))] == times
    with log.open() as file:
        assert [line["time_s"] for line in decode(file)] == times
    with log.open() as file:
        file.readline()
        assert len(list(decode(file))) == 5
    assert [line["time_s"] for line in decode(iter(DELTAS), stamps="delta")] == times
    # Lines that come one by one: what to do is said for Python.
    with pytest.raises(LogError, match='give stamps="delta" if they are, stamps="zero" if not'):
        list(decode(iter(DELTAS)))


def test_what_gives_no_lines_of_text_is_refused(tmp_path: Path) -> None:
    log = tmp_path / "run.log"
    log.write_text(LOG)
    with log.open("rb") as file, pytest.raises(InputError) as caught:
        list(decode(file))  # type: ignore[arg-type]
    assert "line 1 of the log: expected text, got b'" in str(caught.value)
    assert str(caught.value).endswith("open the log as text, or give its path")
    wrong: List[Any] = [b"(1.0) can0 029#", 5, None]
    for what in wrong:
        with pytest.raises(InputError, match="log: expected a path, or lines of text, got"):
            decode(what)
    wrong = [["(1.0) can0 029#", None], iter(["(1.0) can0 029#", 7])]
    for what in wrong:
        with pytest.raises(InputError, match="line 2 of the log: expected text, got"):
            list(decode(what))


def plain(value: Any) -> Any:
    """As JSON has it."""
    return json.loads(json.dumps(value))


@pytest.mark.parametrize("options", ([], ["--revision", "1.2a"], ["--protocol", "canopen"]))
def test_every_line_is_that_of_the_tool(
    options: List[str], tmp_path: Path, motionctl: Callable[..., str]
) -> None:
    log = tmp_path / "motion.log"
    if "canopen" in options:
        motionctl("sim", "--drives", "zlac", "--candump", str(log))
    else:
        motionctl("sim", "--candump", str(log))
    printed = motionctl("decode", "--json", *options, str(log))
    tool = [json.loads(line) for line in printed.splitlines()]
    tool = [line for line in tool if line["kind"] in ("frame", "other")]
    assert len(tool) > 1000
    protocol = "canopen" if "canopen" in options else "dyn"
    revision = "1.2A" if "--revision" in options else None
    ours: List[Dict[str, Any]] = list(decode(log, protocol=protocol, revision=revision))
    assert len(ours) == len(tool)
    for mine, other in zip(ours, tool):
        del mine["line"]
        assert plain(mine) == other
