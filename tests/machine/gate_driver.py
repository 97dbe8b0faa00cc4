"""A gate driver DRV8301 (TI, SLOS719) as far as a program can tell: its four registers on the SPI, and when they are there."""

from stm32f405 import MS, US

#: Addresses of the registers.
STATUS_1, STATUS_2, CONTROL_1, CONTROL_2 = range(4)
READ, FRAME_FAULT, FAULT = 1 << 15, 1 << 15, 1 << 10
#: STATUS_2: which device it is.
IDENTITY = 1
#: Bits of the control registers that can be written.
WRITABLE = {CONTROL_1: 0x7FB, CONTROL_2: 0x7F}

#: From the rise of EN_GATE until it answers, and how long EN_GATE is low at least if all of it is to start anew.
READY, RESET = 10 * MS, 30 * US


class GateDriver:
    """On a bus of the chip, chosen by one of its pins, enabled by another. `status` are bits of STATUS_1; those of a fault pull the pin
    `fault` low."""

    mode, fastest, bits = 1, 10_000_000, 16

    def __init__(self, spi, select, enable, fault=None):
        self.chip, self.select, self.enable, self.fault = spi.chip, select, enable, fault
        self.registers, self.answer, self.frame, self.ready_at, self.off_at = {}, 0, [], None, 0
        self.status = 0
        self.clear()
        spi.devices.append(self)
        pins = self.chip.pins
        pins.watchers[select], pins.watchers[enable] = self.on_select, self.on_enable
        if fault:
            pins.drive(fault, 1)

    def clear(self):
        self.registers = {CONTROL_1: 0, CONTROL_2: 0}
        self.answer = 0

    def on_enable(self, level):
        now = self.chip.now()
        if level and self.ready_at is None:
            if now - self.off_at > RESET:
                self.clear()
            self.ready_at = now + READY
            self.show(0)
        elif not level and self.ready_at is not None:
            self.ready_at, self.off_at = None, now

    def show(self, status):
        """Faults of the stage, as bits of STATUS_1."""
        self.status = status | (FAULT if status else 0)
        if self.fault:
            self.chip.pins.drive(self.fault, int(not status))

    def is_ready(self):
        return self.ready_at is not None and self.chip.time >= self.ready_at

    def exchange(self, word):
        """What it sends in a frame is the answer to the frame before."""
        self.frame.append(word)
        return self.answer if len(self.frame) == 1 and self.is_ready() else 0xFFFF

    def on_select(self, level):
        """A frame ends when nobody chooses it any more. One of another length is void."""
        if level != 1 or not self.frame:
            return
        words, self.frame = self.frame, []
        if not self.is_ready():
            return
        if len(words) != 1:
            self.answer = FRAME_FAULT
            return
        (word,) = words
        address, data = word >> 11 & 15, word & 0x7FF
        if address in WRITABLE and not word & READ:
            self.registers[address] = data & WRITABLE[address]
        value = {STATUS_1: self.status, STATUS_2: IDENTITY}.get(address, self.registers.get(address, 0))
        # Behind a command that writes it tells its first status.
        self.answer = address << 11 | value if word & READ else self.status
