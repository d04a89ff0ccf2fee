"""python-canopen's LocalNode as the drive, our SDO client as the master."""

import canopen
from canopen import objectdictionary
from canopen.objectdictionary import datatypes

import dictionary
from bridge import Bridge

NODE = 4
# The client's waiting time, and the time after a reply in which it does not ask for the same object again.
REPLY_US = 50_000
SETTLE_US = 1_000

# Index, sub-index, width and values of each type, both ends of each range.
VALUES = [
    (0x6061, 0, 1, [-128, 3, 127]),
    (0x1001, 0, 1, [0, 255]),
    (0x6077, 0, 2, [-32768, -1, 32767]),
    (0x6041, 0, 2, [0, 0x4427, 65535]),
    (0x6064, 0, 4, [-(2**31), -1, 2**31 - 1]),
    (0x1018, 1, 4, [0x100, 2**32 - 1]),
]
WRITES = [
    (0x6060, 0, 1, 3),
    (0x1400, 2, 1, 254),
    (0x2011, 0, 2, -360),
    (0x2000, 0, 2, 32767),
    (0x60FF, 0, 4, -1000),
    (0x6083, 0, 4, 32767),
]


def bits(value, width):
    return value & (2 ** (8 * width) - 1)


class Client:
    """Our client and python-canopen's drive on one wire"""

    def __init__(self, program, checks):
        self.checks = checks
        self.bridge = Bridge(program, "client")
        self.network = canopen.Network(self.bridge)
        self.node = canopen.LocalNode(NODE, dictionary.load(program, NODE))
        self.network.add_node(self.node)
        self.network.connect()

    def object(self, index, sub):
        entry = self.node.sdo[index]
        return entry if isinstance(entry, canopen.sdo.SdoVariable) else entry[sub]

    def read(self, index, sub=0):
        """Starts a read, of an object that was asked for long ago; how it ends."""
        self.settle()
        return self.bridge.command(f"read {index:04X} {sub:02X}") or self.bridge.answer()

    def write(self, index, sub, width, value):
        self.settle()
        line = f"write {index:04X} {sub:02X} {width:X} {bits(value, width):X}"
        return self.bridge.command(line) or self.bridge.answer()

    def settle(self):
        self.bridge.command(f"pass {SETTLE_US}")

    def give_up(self):
        """Lets the transfer time out, and the silence after it pass."""
        ended = self.bridge.command(f"pass {REPLY_US}")
        self.bridge.command(f"pass {REPLY_US}")
        return ended

    def run(self):
        self.widths()
        self.refusals()
        self.silence()
        self.damage()
        self.segments()
        self.repetition()
        self.printed_confirmation()
        self.network.disconnect()

    def widths(self):
        for index, sub, width, values in VALUES:
            for value in values:
                self.object(index, sub).raw = value
                expected = f"end value {width} {bits(value, width):X}"
                self.checks.same(f"upload {index:04X}h:{sub:02X} = {value}", expected, self.read(index, sub))
        for index, sub, width, value in WRITES:
            self.checks.same(f"download {index:04X}h:{sub:02X}", "end written", self.write(index, sub, width, value))
            self.checks.same(f"{index:04X}h:{sub:02X} holds", value, self.object(index, sub).raw)

    def refusals(self):
        self.checks.same("unknown object", "end aborted 06020000", self.read(0x7000))
        self.checks.same("unknown sub-index", "end aborted 06090011", self.read(0x1018, 9))
        self.checks.same("no value", "end aborted 060A0023", self.read(0x2025))
        self.checks.same("read-only", "end aborted 06010002", self.write(0x6041, 0, 2, 1))
        self.checks.same("wrong width", "end aborted 06070010", self.write(0x60FF, 0, 2, 1))

    def silence(self):
        self.settle()
        speed = self.object(0x60FF, 0)
        held = []
        self.bridge.wire = lambda message: held.append(message) or []
        # The request arrives, its confirmation does not: the client must not take it for that of the next request.
        self.bridge.command("write 60FF 00 4 64")
        self.checks.becomes("the drive answered", 1, lambda: len(held))
        self.checks.same("the drive took the write", 100, speed.raw)
        self.checks.same("second transfer", ["busy running"], self.bridge.command("read 6064 00"))
        self.checks.same("silence", ["end timed-out"], self.bridge.command(f"pass {REPLY_US}"))
        aborted = lambda: self.node.sdo.last_received_error
        self.checks.becomes("the drive heard the abort", 0x05040000, aborted)
        self.checks.same("quiet after it", ["busy quarantined"], self.bridge.command("write 60FF 00 4 0"))
        late = held[0]
        self.bridge.put(late.arbitration_id, late.data)
        self.checks.same("late confirmation", "ignored unawaited", self.bridge.answer())
        self.checks.same("speed before the stop", 100, speed.raw)
        self.bridge.command(f"pass {REPLY_US}")
        self.bridge.wire = lambda message: [message]
        self.checks.same("stop afterwards", "end written", self.write(0x60FF, 0, 4, 0))
        self.checks.same("speed after the stop", 0, speed.raw)

    def damage(self):
        """The drive's reply with one thing changed is not believed; the sound one behind it is."""
        changes = {
            "wrong index": ("address", lambda data: data[:1] + bytes([data[1] ^ 1]) + data[2:]),
            "wrong index, high byte": ("address", lambda data: data[:2] + bytes([data[2] ^ 1]) + data[3:]),
            "wrong sub-index": ("address", lambda data: data[:3] + b"\x01" + data[4:]),
            "value in place of a confirmation": ("direction", lambda data: b"\x43" + data[1:]),
            "segment, toggle 0": ("malformed", lambda data: b"\x20" + bytes(7)),
            "segment, toggle 1": ("malformed", lambda data: b"\x30" + bytes(7)),
            **{f"{length} bytes": ("malformed", lambda data, length=length: data[:length]) for length in range(8)},
        }
        for name, (reason, change) in changes.items():
            self.bridge.wire = lambda message: [self.changed(message, change), message]
            self.checks.same(name, f"ignored {reason}", self.write(0x60FF, 0, 4, 7))
            self.checks.same(f"sound reply behind {name}", "end written", self.bridge.answer())
        self.settle()
        # Another drive's confirmation of the same object.
        held = []
        self.bridge.wire = lambda message: held.append(message) or []
        self.bridge.command("write 60FF 00 4 7")
        self.checks.becomes("the drive answered again", 1, lambda: len(held))
        self.bridge.put(0x580 + NODE + 1, bytes.fromhex("60FF600000000000"))
        self.checks.same("another drive", "ignored foreign", self.bridge.answer())
        self.checks.same("still open", ["end timed-out"], self.give_up())
        self.bridge.wire = lambda message: [message]

    @staticmethod
    def changed(message, change):
        changed = message.__copy__()
        changed.data = bytearray(change(bytes(message.data)))
        changed.dlc = len(changed.data)
        return changed

    def segments(self):
        """A string of nine characters needs segments, which the client does not speak: it says so."""
        text = objectdictionary.ODVariable("a string", 0x5FFF)
        text.data_type = datatypes.VISIBLE_STRING
        self.node.object_dictionary.add_object(text)
        self.node.set_data(0x5FFF, 0, b"ZLAC8030L")
        self.checks.same("segmented upload", "end specifier 41", self.read(0x5FFF))
        self.checks.becomes("its abort", 0x05040001, lambda: self.node.sdo.last_received_error)
        self.bridge.command(f"pass {REPLY_US}")

    def repetition(self):
        """CAN can repeat a frame: the repeated reply must not answer the next request."""
        self.object(0x6064, 0).raw = 1
        self.bridge.wire = lambda message: [message, message]
        self.checks.same("first of two replies", "end value 4 1", self.read(0x6064))
        self.checks.same("second of two replies", "ignored unawaited", self.bridge.answer())
        self.bridge.wire = lambda message: [message]
        self.checks.same("same object at once", ["busy settling"], self.bridge.command("read 6064 00"))
        self.object(0x6064, 0).raw = 2
        self.checks.same("same object a millisecond later", "end value 4 2", self.read(0x6064))

    def printed_confirmation(self):
        """The guide's confirmation of 6081h with sub-index 01 is believed only when that was asked for (Z1)."""
        as_printed = lambda data: data[:3] + b"\x01" + data[4:]
        self.bridge.wire = lambda message: [self.changed(message, as_printed)]
        self.checks.same("Z1, strict", "ignored address", self.write(0x6081, 0, 4, 60))
        self.give_up()
        self.bridge.command("tolerate")
        self.checks.same("Z1, tolerated", "end written", self.write(0x6081, 0, 4, 60))
        self.bridge.wire = lambda message: [message]
