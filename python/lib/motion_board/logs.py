"""Logs and frames into words and values."""

from __future__ import annotations

import io
import os
from collections.abc import Iterable as IsIterable
from typing import IO, Any, Dict, Iterable, Iterator, Optional, Union

from . import _native
from .arguments import shown
from .errors import InputError, LogError
from .frame import Frame, identifier

__all__ = ["Decoder", "decode"]

_LOOK_AHEAD = 1 << 16
_LINES_AHEAD = 1000
_LONGEST_LINE = 4096
# Lines that cannot be read before the first frame: then the file is no log.
_PATIENCE = 5


class Decoder:
    """Follows the conversation on a bus, frame by frame: which side sent a frame, and what it means.

    ``protocol``: "dyn" for DYN drives, "canopen" for ZLAC8030L. ``revision``: "1.2A" or "1.6A"; None: as the drives show it.
    ``reply_ms``: for so long a request waits for its reply.
    """

    def __init__(
        self, protocol: str = "dyn", revision: Optional[str] = None, reply_ms: float = 10.0
    ) -> None:
        """Before the first frame."""
        self._decoder = _native.FrameDecoder(protocol, revision, reply_ms)

    def hear(self, frame: Frame, time_s: Optional[float] = None) -> Dict[str, Any]:
        """What a frame says that ended at this time: the dictionary that ``motionctl decode --json`` prints for it.

        ``text`` is the meaning in words, ``protocol`` "dyn", "canopen" or "foreign"; the values have names that end in their unit.
        """
        return self._decoder.hear(identifier(frame), frame.data, frame.extended, frame.remote, time_s)


def decode(
    log: Union[str, "os.PathLike[str]", Iterable[str]],
    protocol: str = "dyn",
    revision: Optional[str] = None,
    reply_ms: float = 10.0,
    stamps: Optional[str] = None,
    errors: str = "raise",
) -> Iterator[Dict[str, Any]]:
    """What a log says, line by line, as ``motionctl decode --json`` prints it.

    ``log``: the path of a log of candump, python-can, PEAK, Vector or SavvyCAN, or its lines:
    a list of them, a file that is open as text, or anything that gives them one by one. ``protocol``, ``revision``,
    ``reply_ms``: as for :class:`Decoder`. ``stamps``: what short times of candump are, "zero" or "delta"; None: as they show
    in the first lines, which are not known of lines that come one by one.
    ``errors``: what becomes of a line that cannot be read: "raise" raises :class:`motion_board.LogError` with file, line and column;
    "yield" gives a dictionary whose ``kind`` is "error", and goes on.

    The dictionaries have ``kind`` "frame" or "other", ``line`` (from 1), ``time_s`` (None in a log without times), ``interface`` and
    ``text``; frames have ``id``, ``data``, ``protocol`` and their values as well. Statistics are left to the tool.

    Raises :class:`motion_board.LogError` for what is no log in any case.
    """
    if errors not in ("raise", "yield"):
        raise InputError(f'errors: expected "raise" or "yield", got {errors!r}')
    decoder = _native.LogDecoder(protocol, revision, reply_ms, stamps)
    if isinstance(log, (str, os.PathLike)):
        path = os.fspath(log)
        # Opened here, so that a file that is not there is an error at once.
        return _of_file(decoder, open(path, "rb"), path, errors == "raise")
    if isinstance(log, (bytes, bytearray, memoryview)) or not isinstance(log, IsIterable):
        raise InputError(f"log: expected a path, or lines of text, got {shown(log)}")
    decoder.look_ahead(_first_lines(log))
    return _of_lines(decoder, iter(log), "<lines>", errors == "raise")


def _first_lines(log: Iterable[str]) -> str:
    """What can be read twice of the lines; nothing of those that come one by one."""
    if isinstance(log, (list, tuple)):
        return "\n".join(line for line in log[:_LINES_AHEAD] if isinstance(line, str))
    if isinstance(log, io.TextIOBase) and log.seekable():
        try:
            place = log.tell()
        except OSError:
            # Lines of it were taken one by one already.
            return ""
        begin = log.read(_LOOK_AHEAD)
        log.seek(place)
        return begin
    return ""


def _of_file(
    decoder: _native.LogDecoder, file: IO[bytes], name: str, strict: bool
) -> Iterator[Dict[str, Any]]:
    with file:
        begin = file.read(_LOOK_AHEAD)
        if b"\0" in begin or begin.startswith((b"\xff\xfe", b"\xfe\xff")):
            raise LogError(name, 1, None, "expected a log in text (UTF-8), got binary data: export it as text")
        decoder.look_ahead(begin.decode("utf-8", "replace"))
        file.seek(0)
        lines = (line.decode("utf-8", "replace") for line in _bounded(file))
        yield from _of_lines(decoder, lines, name, strict)


def _bounded(file: IO[bytes]) -> Iterator[bytes]:
    """Lines; of one that is too long the first bytes, so that a file without line ends does not fill the memory."""
    while line := file.readline(_LONGEST_LINE + 2):
        yield line
        while not line.endswith(b"\n") and (line := file.readline(_LOOK_AHEAD)):
            pass


def _of_lines(
    decoder: _native.LogDecoder, lines: Iterator[str], name: str, strict: bool
) -> Iterator[Dict[str, Any]]:
    has_entry, damaged = False, 0
    for number, line in enumerate(lines, 1):
        if not isinstance(line, str):
            hint = ": open the log as text, or give its path" if isinstance(line, bytes) else ""
            raise InputError(f"line {number} of the log: expected text, got {shown(line)}{hint}")
        if len(line.rstrip("\r\n")) > _LONGEST_LINE:
            said = [_too_long()]
        else:
            said = decoder.line(line)
        for entry in said:
            if entry["kind"] == "error":
                damaged += not has_entry
                is_no_log = entry.pop("ends_log") or (not has_entry and damaged >= _PATIENCE)
                if strict or is_no_log:
                    raise LogError(name, number, entry["column"], entry["error"])
            else:
                has_entry = True
            entry["line"] = number
            yield entry


def _too_long() -> Dict[str, Any]:
    error = f"expected a line of at most {_LONGEST_LINE} bytes, got a longer one"
    return {"kind": "error", "error": error, "column": _LONGEST_LINE + 1, "ends_log": False}
