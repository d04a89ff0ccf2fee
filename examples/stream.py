#!/usr/bin/env python3
"""Streams a circle on two axes into a running motion, with the standard library alone. docs/stream.md is the protocol.

    motionctl run --slcan /tmp/can-adapter --drives 1,2 --stream tcp:7001 --yes
    examples/stream.py 7001 --seconds 60
"""
import argparse, math, random, socket, time

parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
parser.add_argument("port", type=int)
parser.add_argument("--seconds", type=float, default=60.0)
parser.add_argument("--pause", type=float, default=0.05, help="longest random pause of this program, in seconds")
parser.add_argument("--silence", type=float, default=0.0, help="one pause of so many seconds in the middle")
arguments = parser.parse_args()

link = socket.create_connection(("127.0.0.1", arguments.port))
answers = link.makefile("r")
link.sendall(b"time_s,x_deg,y_deg\n")
word, _, credit = answers.readline().split()
assert word == "ready", "the columns were not understood"
sent, dealt_with, credit = 0, 1, int(credit)

for point in range(round(arguments.seconds * 50) + 1):
    at = point / 50
    # The circle begins and ends slowly: its angle is a minimum-jerk curve of some turns and a quarter.
    share = at / arguments.seconds
    angle = 2 * math.pi * (round(arguments.seconds / 4) + 0.25) * (10 - 15 * share + 6 * share * share) * share**3
    while sent + 1 >= dealt_with + credit:  # nothing is sent without credit; the line of names was the first
        answer = answers.readline()
        word, *rest = answer.split() or ["end"]
        if word in ("error", "end"):
            raise SystemExit(f"after {sent} set-points: {answer.strip() or 'the connection broke'}")
        if word == "ok":
            dealt_with, credit = int(rest[0]), int(rest[1])
    link.sendall(f"{at:.3f},{90 * (1 - math.cos(angle)):.4f},{90 * math.sin(angle):.4f}\n".encode())
    sent += 1
    time.sleep(random.uniform(0, arguments.pause) if point % 10 == 0 else 0)
    time.sleep(arguments.silence if point == round(arguments.seconds * 25) else 0)
link.sendall(b"end\n")
print(f"sent {sent} set-points;", next((line for line in answers if line.startswith("end")), "the connection broke").strip())
