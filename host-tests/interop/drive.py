"""python-canopen's BaseNode402 as the master, our simulated drive as the drive."""

import time

import canopen
from canopen.profiles.p402 import BaseNode402
from canopen.sdo import SdoAbortedError

import dictionary
from bridge import PATIENCE_S, Bridge

NODE = 5
ENCODER_COUNTS = 4096

# On a busy machine everything takes longer; nothing here tests how fast it is.
BaseNode402.TIMEOUT_SWITCH_OP_MODE = PATIENCE_S
BaseNode402.TIMEOUT_SWITCH_STATE_FINAL = PATIENCE_S
BaseNode402.TIMEOUT_SWITCH_STATE_SINGLE = PATIENCE_S
BaseNode402.TIMEOUT_CHECK_TPDO = PATIENCE_S


class Drive:
    """python-canopen's master and our drive on one wire"""

    def __init__(self, program, checks):
        self.checks = checks
        self.bridge = Bridge(program, "drive", str(NODE))
        self.network = canopen.Network(self.bridge)
        self.node = BaseNode402(NODE, dictionary.load(program, NODE))
        self.boots = 0
        self.node.nmt.add_heartbeat_callback(self.count_boot)
        self.network.add_node(self.node)
        self.network.connect()
        self.sdo = self.node.sdo
        self.sdo.RESPONSE_TIMEOUT = PATIENCE_S

    def count_boot(self, state):
        self.boots += state == 0

    def wheel(self):
        _, counts, rpm = self.bridge.command("wheel")[0].split()
        return int(counts), float(rpm)

    def turns(self, rpm):
        self.checks.becomes(f"wheel at {rpm} r/min", rpm, lambda: round(self.wheel()[1], 3))

    def stands_at(self, counts):
        self.checks.becomes(f"wheel stands at {counts}", (counts, 0.0), self.wheel)

    def run(self):
        self.start()
        self.transfers()
        self.heartbeat()
        self.mapping()
        self.state_machine()
        self.velocity()
        self.position()
        self.sync()
        self.fault()
        self.restart()
        self.network.disconnect()

    def start(self):
        self.checks.becomes("boot-up", 1, lambda: self.boots)
        self.checks.same("pre-operational after boot-up", "PRE-OPERATIONAL", self.node.nmt.state)
        self.checks.same("device type", 0x40192, self.sdo[0x1000].raw)
        self.checks.same("vendor", 0x100, self.sdo[0x1018][1].raw)
        self.checks.same("product", 1, self.sdo[0x1018][2].raw)

    def transfers(self):
        self.sdo[0x2010].raw = 1
        for index, value in [(0x6060, 1), (0x2011, -360), (0x2014, 100), (0x6071, -1000), (0x60FF, -5), (0x6083, 100)]:
            self.sdo[index].raw = value
            self.checks.same(f"{index:04X}h reads back", value, self.sdo[index].raw)
        self.checks.same("no write reached the EEPROM", ["wear 0 0"], self.bridge.command("wear"))
        refuse = lambda what, code, action: self.checks.raises(what, SdoAbortedError, code, action)
        refuse("read-only", 0x06010002, lambda: self.sdo.download(0x6041, 0, b"\0\0"))
        refuse("range", 0x06090030, lambda: self.sdo.download(0x60FF, 0, (1001).to_bytes(4, "little")))
        refuse("width", 0x06070010, lambda: self.sdo.download(0x60FF, 0, b"\1\0"))
        refuse("no object", 0x06020000, lambda: self.sdo.upload(0x7000, 0))
        refuse("no sub-index", 0x06090011, lambda: self.sdo.upload(0x60FF, 1))
        refuse("segmented download", 0x05040001, lambda: self.sdo.download(0x60FF, 0, bytes(4), force_segment=True))
        # The moves below pause longer than the offline time.
        self.sdo[0x2000].raw = 0

    def heartbeat(self):
        self.sdo[0x1017].raw = 50
        self.checks.same("heartbeat", "PRE-OPERATIONAL", self.node.nmt.wait_for_heartbeat(PATIENCE_S))
        for command, state in [("OPERATIONAL", "OPERATIONAL"), ("STOPPED", "STOPPED"), ("PRE-OPERATIONAL",) * 2]:
            self.node.nmt.state = command
            self.checks.becomes(f"heartbeat says {state}", state, lambda: self.node.nmt.wait_for_heartbeat(PATIENCE_S))

    def map(self, communication, mapping, number, words, kind, timer=0):
        """The printed sequence: the identifier of a PDO is read-only here, so python-canopen's own `save` cannot be used (Z20)."""
        self.sdo[mapping + number][0].raw = 0
        for sub, word in enumerate(words, 1):
            self.sdo[mapping + number][sub].raw = word
        self.sdo[communication + number][2].raw = kind
        self.sdo[communication + number][5].raw = timer
        self.sdo[mapping + number][0].raw = len(words)

    def mapping(self):
        self.map(0x1800, 0x1A00, 0, [0x60410010, 0x606C0020, 0x60610008], 1)
        self.map(0x1800, 0x1A00, 1, [0x60640020], 255, timer=40)
        self.map(0x1400, 0x1600, 1, [0x60FF0020], 255)
        occupied = lambda: self.sdo.download(0x1A00, 1, (0x60640020).to_bytes(4, "little"))
        self.checks.raises("mapping in force", SdoAbortedError, 0x06010000, occupied)
        self.node.nmt.state = "PRE-OPERATIONAL"
        self.node.nmt.wait_for_heartbeat(PATIENCE_S)
        self.network.sync.start(0.02)
        self.node.setup_402_state_machine()
        names = lambda pdo: [(variable.index, len(variable.od)) for variable in pdo]
        self.checks.same("mapped to the master", [(0x6041, 16), (0x606C, 32), (0x6061, 8)], names(self.node.tpdo[1]))
        self.checks.same("mapped to the drive", [(0x60FF, 32)], names(self.node.rpdo[2]))
        self.checks.same("identifiers", (0x185, 0x305), (self.node.tpdo[1].cob_id, self.node.rpdo[2].cob_id))
        self.node.nmt.state = "OPERATIONAL"
        self.checks.same("process data with SYNC", True, self.node.tpdo[1].wait_for_reception(PATIENCE_S) is not None)
        self.checks.same("process data by timer", True, self.node.tpdo[2].wait_for_reception(PATIENCE_S) is not None)

    def state_machine(self):
        state = lambda: self.node.state
        self.checks.becomes("off", "SWITCH ON DISABLED", state)
        self.sdo[0x60FF].raw = 0
        for target in ["READY TO SWITCH ON", "SWITCHED ON", "OPERATION ENABLED", "QUICK STOP ACTIVE",
                       "OPERATION ENABLED", "SWITCHED ON", "READY TO SWITCH ON", "SWITCH ON DISABLED"]:
            self.node.state = target
            self.checks.same(f"state {target}", target, self.node.state)
        # All the way in one assignment.
        self.node.state = "OPERATION ENABLED"
        self.checks.same("enabled", "OPERATION ENABLED", self.node.state)

    def set_mode(self, value, name):
        self.sdo[0x6060].raw = value
        self.checks.becomes(f"mode {name}", name, lambda: self.node.op_mode)

    def command_speed(self, rpm):
        self.node.rpdo[2][0].raw = rpm
        self.node.rpdo[2].transmit()

    def velocity(self):
        self.set_mode(3, "PROFILED VELOCITY")
        for rpm in [100, -50]:
            self.command_speed(rpm)
            self.turns(rpm)
            self.checks.becomes("606Ch in 0.1 r/min", rpm * 10, lambda: self.node.tpdo_values[0x606C])
            self.checks.becomes("speed reached", 0x0400, lambda: self.node.statusword & 0x0400)
        self.node.state = "QUICK STOP ACTIVE"
        self.turns(0)
        self.checks.same("energised after a quick stop", 0x07, self.node.statusword & 0x2F)
        self.node.state = "OPERATION ENABLED"
        self.turns(-50)
        self.command_speed(0)
        self.turns(0)

    def move(self, counts, words):
        self.sdo[0x607A].raw = counts
        for word in words:
            self.node.controlword = word
        self.checks.becomes("set-point acknowledged", 0x1000, lambda: self.node.statusword & 0x1000)

    def position(self):
        self.set_mode(1, "PROFILED POSITION")
        self.sdo[0x6081].raw = 600
        self.sdo[0x2005].raw = 1
        origin = self.wheel()[0]
        relative, absolute = (0x4F, 0x5F), (0x0F, 0x1F)
        for counts, words, target in [(ENCODER_COUNTS, relative, 4096), (ENCODER_COUNTS, relative, 8192), (-1000, absolute, -1000)]:
            self.move(counts, words)
            self.stands_at(origin + target)
            self.checks.becomes("target reached", 0x0400, lambda: self.node.statusword & 0x0400)
        self.checks.becomes("position by PDO", -1000, lambda: self.node.tpdo_values[0x6064])

    def sync(self):
        """Without SYNC its PDO stops, the one with a timer goes on."""
        self.network.sync.stop()
        time.sleep(0.3)
        self.checks.same("no SYNC, no PDO", None, self.node.tpdo[1].wait_for_reception(0.3))
        self.checks.same("timer goes on", True, self.node.tpdo[2].wait_for_reception(PATIENCE_S) is not None)
        self.network.sync.start(0.02)

    def fault(self):
        self.bridge.command("trip 0204")
        heard = lambda: [(emergency.code, emergency.register) for emergency in self.node.emcy.log]
        self.checks.becomes("emergency message", [(0x1000, 1)], heard)
        self.checks.becomes("fault", "FAULT", lambda: self.node.state)
        self.checks.same("603Fh", 0x0204, self.sdo[0x603F].raw)
        self.node.controlword = 0x0080
        self.checks.same("not reset while the cause is there", 0x0204, self.sdo[0x603F].raw)
        self.bridge.command("cure")
        self.node.controlword = 0x0000
        self.node.reset_from_fault()
        self.checks.same("reset and enabled", "OPERATION ENABLED", self.node.state)
        self.checks.same("603Fh after it", 0, self.sdo[0x603F].raw)

    def restart(self):
        self.network.sync.stop()
        self.bridge.command("power-cycle")
        self.checks.becomes("boot-up again", 2, lambda: self.boots)
        self.checks.same("2010h is not stored", 0, self.sdo[0x2010].raw)
        self.checks.same("nor is what was written under it", (500, 0), (self.sdo[0x6083].raw, self.sdo[0x1017].raw))
        self.checks.same("nothing wore the EEPROM", ["wear 0 0"], self.bridge.command("wear"))
        self.sdo[0x1017].raw = 0
        self.checks.same("but now", ["wear 1 0"], self.bridge.command("wear"))
