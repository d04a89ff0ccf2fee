"""Servo axes on CAN: codecs, log decoder, bus plan, simulator, and the link to a motion board.

Warning: :class:`Board` moves real machinery.

====================  ====================================================================
``dyn_can``           messages of DYN drives on CAN, both revisions
``dyn_serial``        packets of DYN drives on RS232
``canopen``           frames of ZLAC8030L drives on CANopen
``decode``            a log into words and values; :class:`Decoder` frame by frame
``plan``              whether a bus carries its axes
``simulate``          a motion on simulated drives, in virtual time
:class:`Board`        the link to a motion board
``testing``           a board without a machine
``errors``            every exception
====================  ====================================================================
"""

from . import canopen, dyn_can, dyn_serial, errors, testing
from .board import (
    AxisSnapshot,
    Board,
    Counters,
    Event,
    Fault,
    Info,
    Origin,
    Progress,
    Settings,
    Snapshot,
    StreamResult,
)
from .bus_plan import Plan, PlannedFrame, plan
from .errors import (
    BoardError,
    CodecError,
    ConnectionLost,
    InputError,
    LogError,
    MotionBoardError,
    NoReply,
    NotConnected,
    Refused,
    StreamStopped,
)
from .frame import Frame
from .logs import Decoder, decode
from .simulator import AxisResult, Simulation, simulate

__all__ = [
    "AxisResult",
    "AxisSnapshot",
    "Board",
    "BoardError",
    "CodecError",
    "ConnectionLost",
    "Counters",
    "Decoder",
    "Event",
    "Fault",
    "Frame",
    "Info",
    "InputError",
    "LogError",
    "MotionBoardError",
    "NoReply",
    "NotConnected",
    "Origin",
    "Plan",
    "PlannedFrame",
    "Progress",
    "Refused",
    "Settings",
    "Simulation",
    "Snapshot",
    "StreamResult",
    "StreamStopped",
    "canopen",
    "decode",
    "dyn_can",
    "dyn_serial",
    "errors",
    "plan",
    "simulate",
    "testing",
]
