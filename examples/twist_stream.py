#!/usr/bin/env python3
"""A joystick for two hub motors, with the standard library alone: prints a line time,v,omega twenty times a second.

    examples/twist_stream.py | motionctl run --drives zlac:4,5 --can can0 --twist - --track 0.4 --wheel-radius 0.085 --yes

The first stick of a Linux joystick: forwards and backwards, left and right. Button 0 ends; so does Ctrl-C, which motionctl has too.
The wheels stop when this program stops: a twist is good for half a second (--dead-man-ms). A stick that is let go is a speed of 0.
"""
import argparse, os, select, struct, sys, time

parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
parser.add_argument("--joystick", default="/dev/input/js0", help="device of the joystick")
parser.add_argument("--speed", type=float, default=0.3, help="m/s with the stick fully forwards")
parser.add_argument("--turn", type=float, default=1.0, help="rad/s with the stick fully to one side")
arguments = parser.parse_args()

EVENT = struct.Struct("=IhBB")  # time in ms, value, kind, number: linux/joystick.h
BUTTON, AXIS, INITIAL, FULL, DEAD_ZONE = 0x01, 0x02, 0x80, 32767, 0.05


def of_full(value):
    """-1 to 1, and 0 near the middle, where no stick stands exactly."""
    share = max(-1.0, value / FULL)
    return 0.0 if abs(share) < DEAD_ZONE else share


stick, pending, ends = {0: 0.0, 1: 0.0}, b"", False
device, begin = os.open(arguments.joystick, os.O_RDONLY), time.monotonic()
due = begin
while not ends:
    due += 0.05
    while not ends and (left := due - time.monotonic()) > 0 and select.select([device], [], [], left)[0]:
        data = os.read(device, 64 * EVENT.size)
        pending, ends = pending + data, not data  # nothing to read: it was pulled out
        while len(pending) >= EVENT.size:
            (_, value, kind, number), pending = EVENT.unpack(pending[: EVENT.size]), pending[EVENT.size :]
            if kind & ~INITIAL == AXIS and number in stick:
                stick[number] = of_full(value)
            ends |= kind == BUTTON and number == 0 and value == 1
    if ends:
        stick = {0: 0.0, 1: 0.0}
    # Forwards and left are negative values of a stick.
    forwards, left_turn = (0.0 - stick[axis] for axis in (1, 0))
    try:
        print(f"{time.monotonic() - begin:.6f},{forwards * arguments.speed:.4f},{left_turn * arguments.turn:.4f}", flush=True)
    except BrokenPipeError:
        sys.stderr.close()
        raise SystemExit(1)
