"""python-canopen and a virtual drive in virtual time, in one thread: time passes on the drive's clock, and only while python-canopen waits.

So its own limits hold, however busy the PC is. They are 0.4 s for a transition, 0.8 s for the way to a state, 0.5 s for a mode and 0.2 s for
a TPDO (`BaseNode402.TIMEOUT_...`), and 0.3 s for an SDO answer. What it waits with is replaced: the clock, queues and conditions of its
modules. Each look at the clock takes a tenth of a millisecond, so a loop that looks at nothing else ends too.
"""

import queue
import subprocess
import tempfile
from types import SimpleNamespace

import canopen
import canopen.emcy
import canopen.lss
import canopen.nmt
import canopen.pdo.base
import canopen.profiles.p402
import canopen.sdo.client

import frames

#: The modules that wait.
MODULES = [
    canopen.emcy,
    canopen.lss,
    canopen.nmt,
    canopen.pdo.base,
    canopen.profiles.p402,
    canopen.sdo.client,
    frames,
]

#: What a look at the clock takes, in seconds.
LOOK = 0.0001

STOP_TIME = 30


class SteppedDrive:
    """The drive as a process, and the bus it is on: the `bus` of a `canopen.Network`, and its clock."""

    def __init__(self, command):
        self.was_killed = False
        self.network = None
        self.now = 0
        self.log = tempfile.TemporaryFile(mode="w+")
        self.process = subprocess.Popen(
            [str(word) for word in command],
            stdin=subprocess.PIPE,
            stdout=subprocess.PIPE,
            stderr=self.log,
            text=True,
        )

    @property
    def server(self):
        """It is its own server."""
        return self

    def connect(self):
        """A master on the bus."""
        self.network = canopen.Network()
        self.network.bus = self
        return self.network

    # What a network asks of its bus.

    def send(self, message):
        data = " rtr" if message.is_remote_frame else "".join(f" {byte:02X}" for byte in message.data)
        self.process.stdin.write(f"{message.arbitration_id:03X} [{message.dlc}]{data}\n")

    def shutdown(self):
        self.network = None

    # What its own kind has beside.

    def happen(self, event):
        """Something happens to the motor of a servo: `stepped_drive` knows what."""
        self.process.stdin.write(f"!{event}\n")

    # Time.

    def run(self, seconds, is_over=lambda: False):
        """Lets time pass, until something is over, and hands over what the drive sends."""
        end = self.now + round(seconds * 1e6)
        while not is_over() and (left := end - self.now) > 0:
            self.process.stdin.write(f"+{left}\n")
            self.process.stdin.flush()
            line = self.process.stdout.readline()
            heard = None
            if not line.startswith("="):
                heard, line = line, self.process.stdout.readline()
            assert line.startswith("="), f"the drive has ended: {self.words()}"
            self.now = int(line[1:])
            if heard is not None and self.network is not None:
                cob_id, *data = heard.split()
                # `704 [1] 05`, `584: 60 17 10 00 00 00 00 00`
                data = bytearray(int(byte, 16) for byte in data if not byte.startswith("["))
                self.network.notify(int(cob_id.rstrip(":"), 16), data, self.now / 1e6)
        return is_over()

    def monotonic(self):
        self.run(LOOK)
        return self.now / 1e6

    # As every server.

    def words(self):
        """What it wrote to its standard error."""
        self.log.seek(0)
        return self.log.read()

    def stop(self):
        """Stops it, and gives its exit code."""
        if not self.process.stdin.closed:
            self.process.stdin.close()
        code = self.process.wait(STOP_TIME)
        self.process.stdout.close()
        if code == 0:
            self.log.close()
        return code


class VirtualTime:
    """Replaces what python-canopen waits with, as long as the test lasts."""

    def __init__(self, monkeypatch):
        self.drive = None
        for module in MODULES:
            for name, replacement in (
                ("time", self.time()),
                ("queue", SimpleNamespace(Queue=self.queue_class(), Empty=queue.Empty)),
                ("threading", SimpleNamespace(Condition=self.condition_class())),
            ):
                if hasattr(module, name):
                    monkeypatch.setattr(module, name, replacement)

    def start(self, command):
        """Starts the drive whose clock it is."""
        assert self.drive is None, "one drive, one clock"
        self.drive = SteppedDrive(command)
        return self.drive

    def time(self):
        return SimpleNamespace(
            monotonic=lambda: self.drive.monotonic(),
            time=lambda: self.drive.monotonic(),
            sleep=lambda seconds: self.drive.run(seconds),
        )

    def queue_class(self):
        virtual = self

        class Queue(queue.Queue):
            def get(self, block=True, timeout=None):
                if block:
                    assert timeout is not None, "it would wait for ever"
                    virtual.drive.run(timeout, lambda: not self.empty())
                return super().get(block=False)

        return Queue

    def condition_class(self):
        virtual = self

        class Condition:
            def __init__(self):
                self.times = 0

            def __enter__(self):
                return self

            def __exit__(self, *_):
                pass

            def notify_all(self):
                self.times += 1

            def wait(self, timeout=None):
                assert timeout is not None, "it would wait for ever"
                before = self.times
                return virtual.drive.run(timeout, lambda: self.times != before)

        return Condition
