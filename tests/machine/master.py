"""python-canopen and the chip, in one thread: time passes on the chip's clock, and only while python-canopen waits (`stepped.py`)."""

import functools

import canopen
from canopen.profiles.p402 import BaseNode402

from frames import Frames
from judge import FACTORY
from stepped import LOOK
from stm32f405 import HZ, MS
from stm32f405.bxcan import Frame


@functools.cache
def data_sheet(eds, node_id):
    """Reading it takes as long as some of the tests."""
    return canopen.import_od(str(eds), node_id)


class Bench:
    """A chip on a bus with a master: the `bus` of a `canopen.Network`, and its clock."""

    def __init__(self, chip):
        self.chip, self.network = chip, None
        #: What the pulses are judged by (`judge.py`).
        self.pulse_times = FACTORY
        #: Every frame of the chip, with the moment in which it ended.
        self.frames = []
        chip.can.on_frame = self.on_frame

    def copy(self):
        """Another chip in the same state, with what it has sent, on a bus of its own."""
        can = self.chip.can
        can.on_frame = None
        twin = Bench(self.chip.copy())
        can.on_frame = self.on_frame
        twin.frames[:] = self.frames
        return twin

    def connect(self):
        self.network = canopen.Network()
        self.network.bus = self
        return self.network

    def on_frame(self, frame):
        self.frames.append(frame)
        if self.network is not None:
            self.network.notify(frame.id, bytearray(frame.data), frame.time / HZ)

    # What a network asks of its bus.

    def send(self, message):
        frame = Frame(message.arbitration_id, message.is_extended_id, message.is_remote_frame, bytes(message.data))
        self.chip.can.to_send.append(frame)

    def shutdown(self):
        self.network = None

    # Time.

    def run(self, seconds, is_over=lambda: False):
        return self.chip.run(round(seconds * HZ), is_over)

    def monotonic(self):
        self.run(LOOK)
        return self.chip.time / HZ

    def milliseconds(self, number):
        """Lets so many pass."""
        self.chip.run(number * MS)

    # What every test does.

    def sent_since(self, time, cob_id=None):
        return [f for f in self.frames if f.time > time and cob_id in (None, f.id)]

    def give_node_id(self, node_id, store=False):
        """By LSS, to the only device of the bus."""
        lss = self.network.lss
        boot_up = Frames(self.network, 0x700 + node_id)
        lss.send_switch_state_global(lss.CONFIGURATION_STATE)
        lss.configure_node_id(node_id)
        if store:
            lss.store_configuration()
        lss.send_switch_state_global(lss.WAITING_STATE)
        assert boot_up.next() == b"\x00"

    def add(self, node_id, eds):
        node = BaseNode402(node_id, data_sheet(eds, node_id))
        self.network.add_node(node)
        return node
