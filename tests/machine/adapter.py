"""A serial CAN adapter (SLCAN) between python-can and the bus of the chip: text on one side, frames on the other, in the time of the chip."""

from can import Message
from master import Bench
from stm32f405 import HZ
from stm32f405.bxcan import Frame

CLOSED, BIT_RATE, OPEN, WRONG = "C", "S", "O", b"\a"


class Adapter(Bench):
    """The bench of a chip whose master has nothing but a serial line: `serial` is what pyserial would open, or another program reads and writes."""

    def __init__(self, chip):
        super().__init__(chip)
        self.serial, self.is_open, self.bit_rate = Line(self), False, None
        self.slcan = None

    def connect_by(self, slcan):
        """The network's frames go by this bus of python-can."""
        self.slcan = slcan
        return self.connect()

    def on_frame(self, frame):
        self.frames.append(frame)
        if not self.is_open:
            return
        letter, identifier = ("t", f"{frame.id:03X}") if not frame.extended else ("T", f"{frame.id:08X}")
        self.serial.to_read += f"{letter}{identifier}{len(frame.data)}{frame.data.hex().upper()}\r".encode()
        while self.slcan and self.serial.in_waiting:
            # An answer to a command is a line, too, and no message.
            if (message := self.slcan.recv(0)) is not None:
                self.network.notify(message.arbitration_id, message.data, frame.time / HZ)

    def send(self, message):
        self.slcan.send(Message(
            arbitration_id=message.arbitration_id, is_extended_id=message.is_extended_id, is_remote_frame=message.is_remote_frame,
            data=message.data, dlc=message.dlc,
        ))  # fmt: skip

    def command(self, text):
        """A line of the master; gives the answer."""
        kind, rest = text[:1], text[1:]
        if kind == CLOSED:
            self.is_open = False
        elif kind == BIT_RATE and not self.is_open:
            self.bit_rate = rest
        elif kind == OPEN:
            self.is_open = True
        elif kind in ("t", "r") and self.is_open:
            identifier, length = int(rest[:3], 16), int(rest[3])
            data = bytes.fromhex(rest[4:])
            assert len(data) == (length if kind == "t" else 0)
            self.chip.can.to_send.append(Frame(identifier, False, kind == "r", data))
        else:
            return WRONG
        return b"\r"


class Line:
    """What python-can sees of the adapter."""

    write_timeout = None

    def __init__(self, adapter):
        self.adapter, self.to_read, self.written = adapter, bytearray(), bytearray()

    def write(self, data):
        self.written += data
        while b"\r" in self.written:
            text, _, self.written = self.written.partition(b"\r")
            self.to_read += self.adapter.command(text.decode())

    @property
    def in_waiting(self):
        return len(self.to_read)

    def read(self, number=1):
        data, self.to_read = bytes(self.to_read[:number]), self.to_read[number:]
        return data

    def flush(self):
        pass

    def close(self):
        pass

    def reset_input_buffer(self):
        self.to_read.clear()
