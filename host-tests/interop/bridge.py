"""The other end of `canopen_bridge`: a bus of python-can over the standard input and output of a process."""

import queue
import subprocess
import threading

import can

# Longer than anything takes; a check that waits so long has failed.
PATIENCE_S = 10


class Bridge(can.BusABC):
    """A process that speaks lines, as a bus for python-can and a place to send commands to."""

    def __init__(self, *command):
        self.process = subprocess.Popen(
            command, stdin=subprocess.PIPE, stdout=subprocess.PIPE, text=True, bufsize=1
        )
        self.received = queue.Queue()
        self.answers = queue.Queue()
        # Turns a frame of ours into the frames that go over the wire: none, another, several.
        self.wire = lambda message: [message]
        self.sending = threading.Lock()
        threading.Thread(target=self._read, daemon=True).start()
        super().__init__(channel=" ".join(command[1:]))

    def _read(self):
        for line in self.process.stdout:
            line = line.strip()
            if line.startswith("!"):
                self.answers.put(line[1:])
            else:
                identifier, data = line.split("#")
                self.received.put(
                    can.Message(
                        arbitration_id=int(identifier, 16), data=bytes.fromhex(data), is_extended_id=False
                    )
                )

    def _write(self, line):
        with self.sending:
            self.process.stdin.write(line + "\n")

    def _recv_internal(self, timeout):
        try:
            return self.received.get(timeout=timeout), True
        except queue.Empty:
            return None, True

    def send(self, msg, timeout=None):
        for message in self.wire(msg):
            self.put(message.arbitration_id, message.data)

    def put(self, identifier, data):
        """Sends a frame past the wire's damage."""
        self._write(f"{identifier:03X}#{bytes(data).hex().upper()}")

    def answer(self):
        """The next line of the process that is no frame."""
        return self.answers.get(timeout=PATIENCE_S)

    def command(self, line):
        """Sends a command; what the process says before it is done."""
        self._write(line)
        said = []
        while True:
            answer = self.answer()
            if answer == "done":
                return said
            said.append(answer)

    def shutdown(self):
        super().shutdown()
        self.process.stdin.close()
        self.process.wait(PATIENCE_S)
