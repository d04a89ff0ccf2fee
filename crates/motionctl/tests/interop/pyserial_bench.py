"""The bench's serial port, driven by pyserial, and the same drives over CAN, driven by python-can.

Usage: pyserial_bench.py MOTIONCTL VECTORS

No client for the drives' serial protocol is published, so the packets come from the golden vectors and from the few lines
below, which are written from the manual and share nothing with the product.
"""

import json
import os
import signal
import subprocess
import sys
import tempfile
import time

import can
import serial

BAUD = 38_400
PATIENCE_S = 10

# Set function: (read function, function of the reply, data bytes of the reply).
READ_BACK = {
    "Set_MainGain": (0x18, 0x10, 1),
    "Set_SpeedGain": (0x19, 0x11, 1),
    "Set_IntGain": (0x1A, 0x12, 1),
    "Set_TrqCons": (0x1B, 0x13, 1),
    "Set_HighSpeed": (0x1C, 0x14, 1),
    "Set_HighAccel": (0x1D, 0x15, 1),
    "Set_Pos_OnRange": (0x1E, 0x17, 1),
    "Set_GearNumber": (0x1F, 0x18, 2),
}

# Read function: function of the reply.
REPLY = {
    "Read_Drive_ID": 0x16,
    "Read_Drive_Config": 0x1A,
    "Read_Drive_Status": 0x19,
    **{f"Read_{name}": 0x10 + place for place, name in enumerate(
        ["MainGain", "SpeedGain", "IntGain", "TrqCons", "HighSpeed", "HighAccel"])},
    "Read_Pos_OnRange": 0x17,
    "Read_GearNumber": 0x18,
}


def packet(drive, function, value, data_bytes=1):
    """A packet by the manual, section 7.2: unsigned data in groups of seven bits."""
    data = [0x80 | value >> 7 * place & 0x7F for place in reversed(range(data_bytes))]
    body = [drive, 0x80 | data_bytes - 1 << 5 | function, *data]
    return bytes([*body, 0x80 + sum(body) % 128])


def wait_for(path):
    """Waits until the bench has made its terminal."""
    end = time.monotonic() + PATIENCE_S
    while not os.path.exists(path):
        if time.monotonic() > end:
            sys.exit(f"the bench did not make {path} within {PATIENCE_S} s")
        time.sleep(0.02)


class Host:
    """Asks the drives and counts what was checked."""

    def __init__(self, port):
        self.port = port
        self.checked = 0

    def send(self, data):
        self.port.write(data)
        self.port.flush()

    def receive(self):
        """The next packet: its length is in its second byte."""
        head = self.port.read(2)
        if len(head) < 2:
            return head
        return head + self.port.read(2 + (head[1] >> 5 & 3))

    def expect(self, what, expected, actual):
        self.checked += 1
        if expected != actual:
            sys.exit(f"{what}: expected {expected!r}, got {actual!r}")

    def expect_reply(self, what, request, expected):
        self.send(request)
        reply = self.receive()
        self.expect(what, expected.hex(" "), reply.hex(" "))

    def settings(self, vectors):
        """Every parameter that a vector sets is read back as it was set."""
        for vector in vectors:
            if vector["function"] in READ_BACK:
                read, function, data_bytes = READ_BACK[vector["function"]]
                drive = vector["drive_id"]
                self.send(bytes.fromhex(vector["packet"]))
                expected = packet(drive, function, vector["value"], data_bytes)
                self.expect_reply(vector["name"], packet(drive, read, 0), expected)

    def reads(self, vectors):
        """Every read of the vectors is answered by its drive, with the right function and a right checksum."""
        for vector in vectors:
            if vector["function"] in REPLY:
                self.send(bytes.fromhex(vector["packet"]))
                reply = self.receive()
                head = (vector["drive_id"], REPLY[vector["function"]])
                self.expect(vector["name"], head, (reply[0], reply[1] & 0x1F))
                self.expect(vector["name"], 0x80 + sum(reply[:-1]) % 128, reply[-1])

    def noise(self):
        """Noise in front of a packet, and packets without a gap, cost no packet."""
        read = packet(7, 0x06, 0)
        reply = packet(7, 0x16, 7)
        for noise in ["ff", "07", "0786", "07e68080", "07868080", "ffff7f", "0780"]:
            self.expect_reply(f"behind {noise}", bytes.fromhex(noise) + read, reply)
        self.send(read * 20)
        for place in range(20):
            self.expect(f"glued packet {place}", reply.hex(" "), self.receive().hex(" "))

    def moves(self):
        """A relative move ends where it should."""
        self.send(packet(9, 0x03, 500, 2))
        time.sleep(1.0)
        self.expect_reply("status", packet(9, 0x09, 0), packet(9, 0x19, 0))
        self.expect_reply("position", packet(9, 0x0E, 0x1B), packet(9, 0x1B, 500, 2))

    def both_doors(self, bus):
        """What is written here is read back over CAN, and the other way round."""
        self.send(packet(5, 0x10, 99) + packet(5, 0x12, 88))
        # Answered behind the two commands, so that they have arrived.
        self.expect_reply("id", packet(5, 0x06, 0), packet(5, 0x16, 5))
        bus.send(can.Message(arbitration_id=5 << 5 | 0x13, is_extended_id=False))
        reply = bus.recv(timeout=PATIENCE_S)
        self.expect("main gain over CAN", 99, reply and reply.data[0])
        self.expect("integration gain over CAN", 88, reply and reply.data[2])
        # Set_Param_Group1: speed gain 77, the others stay; the echo behind it says that it has arrived.
        group = can.Message(arbitration_id=5 << 5 | 0x10, data=[0, 77, 0, 0], is_extended_id=False)
        echo = can.Message(arbitration_id=5 << 5 | 0x1E, data=[1, 2, 3, 4], is_extended_id=False)
        bus.send(group)
        bus.send(echo)
        reply = bus.recv(timeout=PATIENCE_S)
        self.expect("echo over CAN", bytes([1, 2, 3, 4]), reply and bytes(reply.data))
        self.expect_reply("speed gain", packet(5, 0x19, 0), packet(5, 0x11, 77))


def main():
    motionctl, vectors = sys.argv[1:]
    with open(vectors, encoding="utf-8") as file:
        requests = [vector for vector in json.load(file)
                    if vector["kind"] == "request" and 1 <= vector["drive_id"] <= 63]
    with tempfile.TemporaryDirectory() as folder:
        port, adapter = (os.path.join(folder, name) for name in ["port", "adapter"])
        bench = subprocess.Popen([motionctl, "bench", "--drives", "1-63", "--serial", port, "--slcan", adapter],
                                 stdout=subprocess.DEVNULL)
        try:
            wait_for(port)
            wait_for(adapter)
            # The drives are ready 150 ms after power-on.
            time.sleep(0.5)
            with serial.Serial(port, BAUD, timeout=PATIENCE_S) as line:
                host = Host(line)
                host.settings(requests)
                host.reads(requests)
                host.noise()
                host.moves()
                with can.Bus(interface="slcan", channel=adapter, bitrate=1_000_000) as bus:
                    host.both_doors(bus)
        finally:
            bench.send_signal(signal.SIGINT)
            status = bench.wait(timeout=PATIENCE_S)
        host.expect("exit status of the bench", 0, status)
    print(f"pyserial {serial.__version__} and python-can {can.__version__}: {host.checked} checks on the bench passed")


main()
