"""The device under test as a process: a virtual drive, or the firmware in the emulator.

Each server is started as a person would start it, is connected to once it has said `ready`, and is stopped by a signal.
"""

import queue
import signal
import socket
import subprocess
import tempfile
import threading

import canopen

#: The machine may be busy with other things: only a server that hangs takes this long, in seconds.
START_TIME = 120
STOP_TIME = 30


def free_port():
    """A TCP port that nobody uses just now."""
    with socket.socket() as probe:
        probe.bind(("127.0.0.1", 0))
        return probe.getsockname()[1]


class Server:
    """A process that runs until it is stopped and says `ready` when it can be reached."""

    def __init__(self, command):
        self.command = [str(word) for word in command]
        self.was_killed = False
        self.log = tempfile.TemporaryFile(mode="w+")
        self.process = subprocess.Popen(
            self.command, stdin=subprocess.DEVNULL, stdout=subprocess.PIPE, stderr=self.log, text=True
        )
        self.lines = queue.Queue()
        threading.Thread(target=self._read, daemon=True).start()

    def _read(self):
        for line in self.process.stdout:
            self.lines.put(line.rstrip("\n"))
        self.lines.put(None)

    def wait_until_ready(self):
        """Takes the lines up to `ready`."""
        try:
            while (line := self.lines.get(timeout=START_TIME)) != "ready":
                assert line is not None, f"{self.command} ended with {self.process.wait()}: {self.words()}"
        except queue.Empty:
            raise AssertionError(f"{self.command} is not ready: {self.words()}") from None

    def words(self):
        """What it wrote to its standard error."""
        self.log.seek(0)
        return self.log.read()

    def kill(self):
        """Ends it at once, as a power cut does."""
        self.was_killed = True
        self.process.kill()
        self.process.wait(STOP_TIME)

    def stop(self, by=signal.SIGTERM):
        """Stops it, and gives its exit code."""
        if self.process.poll() is None:
            self.process.send_signal(by)
        try:
            return self.process.wait(STOP_TIME)
        except subprocess.TimeoutExpired:
            self.process.kill()
            self.process.wait()
            raise AssertionError(f"{self.command} does not stop: {self.words()}") from None


class Slcan:
    """A server whose CAN bus is SLCAN on TCP."""

    def __init__(self, command, port):
        self.port = port
        self.server = Server(command)

    def for_axis402(self):
        """How `axis402` is told to go on the bus."""
        return ["--slcan", f"127.0.0.1:{self.port}"]

    def connect(self, bitrate=1_000_000):
        """A master on the bus."""
        network = canopen.Network()
        network.connect(
            interface="slcan", channel=f"socket://127.0.0.1:{self.port}", bitrate=bitrate, sleep_after_open=0.05
        )
        return network


class Socketcan:
    """A server on a CAN interface of this Linux."""

    INTERFACE = "vcan0"

    def __init__(self, command):
        self.server = Server(command)

    def for_axis402(self):
        """How `axis402` is told to go on the bus."""
        return ["--socketcan", self.INTERFACE]

    def connect(self):
        """A master on the bus."""
        network = canopen.Network()
        network.connect(interface="socketcan", channel=self.INTERFACE)
        return network


class Programs:
    """Where the programs are, and how each kind of device is started."""

    def __init__(self, sim, stepped, axis402, xtask, image):
        self.sim = sim
        self.stepped = stepped
        self.axis402 = axis402
        self.xtask = xtask
        self.image = image

    def start(self, kind, store=None, arguments=()):
        """Starts a device; `store` is a folder in which it keeps its parameters, otherwise they are forgotten."""
        port = free_port()
        slcan = ["--slcan", f"127.0.0.1:{port}"]
        if kind == "firmware":
            command = [self.xtask, "qemu", *slcan]
            command += ["--image", self.image] if self.image else []
            command += ["--store", store] if store else []
        else:
            command = [self.sim, "serve"]
            command += ["--socketcan", Socketcan.INTERFACE] if kind == "socketcan" else slcan
            command += ["--store", store / "parameters.bin"] if store else []
        command += arguments
        bus = Socketcan(command) if kind == "socketcan" else Slcan(command, port)
        bus.server.wait_until_ready()
        return bus
