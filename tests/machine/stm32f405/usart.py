"""The serial lines (RM0090, 30): eight bits without parity, one stop bit, both ways. Other uses are breaches."""

import collections

from .clock import NEVER
from .interrupts import IRQ
from .registers import Peripheral, Register

UE, TXEIE, TCIE, RXNEIE, TE, RE = (1 << bit for bit in (13, 7, 6, 5, 3, 2))
TXE, TC, RXNE, ORE, FE = (1 << bit for bit in (7, 6, 5, 3, 1))

#: Start, eight bits, stop.
BITS = 10

#: By number: the name, the offset of the block, where RCC has its clock, core clocks in one of its bus, the alternate function, pins that may be its
#: output, and its input.
WHICH = {
    1: ("USART1", 0x1_1000, (0x44, 4), 2, 7, ("PA9", "PB6"), ("PA10", "PB7")),
    2: ("USART2", 0x4400, (0x40, 17), 4, 7, ("PA2", "PD5"), ("PA3", "PD6")),
    3: ("USART3", 0x4800, (0x40, 18), 4, 7, ("PB10", "PC10", "PD8"), ("PB11", "PC11", "PD9")),
    4: ("UART4", 0x4C00, (0x40, 19), 4, 8, ("PA0", "PC10"), ("PA1", "PC11")),
}

#: Pins that it drives, with their alternate function.
OUTPUTS = {(pin, function) for _, _, _, _, function, outputs, _ in WHICH.values() for pin in outputs}


class Usart(Peripheral):
    """`on_byte` is told each byte that has left, and when; `receive` sends some to it."""

    READ_SIZES = WRITE_SIZES = (2, 4)
    REGISTERS = {
        0x00: Register("SR", 0, TXE | TC, rc_w0=TC | RXNE, keep=False),
        0x04: Register("DR", 0x1FF),
        0x08: Register("BRR", 0xFFFF),
        0x0C: Register("CR1", 0xBFFF, known=UE | TXEIE | TCIE | RXNEIE | TE | RE),
        0x10: Register("CR2", 0x7F6F, known=0),
        0x14: Register("CR3", 0xFFF, known=0),
    }

    def __init__(self, chip, number):
        self.NAME, self.address, self.CLOCK, self.ratio, self.function, self.outputs, self.inputs = WHICH[number]
        #: Bytes on their way to it, and the clocks of a bit that the sender has, if others than its own.
        self.line, self.line_bit = collections.deque(), None
        self.on_byte = lambda byte, at: None
        super().__init__(chip)

    def reset(self):
        super().reset()
        self.sent_at, self.shift, self.next = NEVER, None, None
        self.received_at, self.data = NEVER, 0

    def bit(self):
        """Core clocks of a bit."""
        return self.ratio * self["BRR"]

    def receive(self, data):
        """Bytes from outside, from now on, one behind the other."""
        self.line.extend(data)
        if self.received_at == NEVER:
            self.received_at = self.chip.time + BITS * (self.line_bit or self.bit())
        self.chip.stale = True

    # Registers.

    def write_BRR(self, value):
        if value < 16:
            self.breach(f"BRR {value:#x}: a divider below 1")
        if self.shift is not None:
            self.breach("BRR written in the middle of a byte")
        self["BRR"] = value

    def write_CR1(self, value):
        for enable, pins, what in ((TE, self.outputs, "output"), (RE, self.inputs, "input")):
            if value & UE and value & enable and not (self["CR1"] & UE and self["CR1"] & enable):
                if sum(self.chip.gpio[pin[1]].function(int(pin[2:])) == self.function for pin in pins) != 1:
                    self.breach(f"it has not one pin for its {what}: {' or '.join(pins)} with function {self.function}")
                if not self["BRR"]:
                    self.breach("switched on without BRR")
        if self["CR1"] & UE and not value & UE and self.shift is not None:
            self.breach("switched off in the middle of a byte")
        self["CR1"] = value
        self.chip.attend(self)

    def write_DR(self, value):
        if self["CR1"] & (UE | TE) != UE | TE:
            return self.breach("DR written while it is off")
        if self.next is not None:
            return self.breach("DR written while a byte waits in it")
        self["SR"] &= ~TC
        if self.shift is None:
            self.begin(value & 0xFF, self.chip.now())
        else:
            self.next = value & 0xFF

    def begin(self, byte, at):
        self.shift, self.sent_at = byte, at + BITS * self.bit()

    def read_SR(self):
        return self["SR"] & ~TXE | (self.next is None) << 7

    def read_DR(self):
        self["SR"] &= ~(RXNE | ORE | FE)
        return self.data

    # Time.

    def next_event(self):
        return min(self.sent_at, self.received_at)

    def event(self):
        if self.sent_at <= self.received_at:
            self.end_sent()
        else:
            self.end_received()

    def end_sent(self):
        at, byte = self.sent_at, self.shift
        self.sent_at, self.shift = NEVER, None
        self.on_byte(byte, at)
        if self.next is None:
            self["SR"] |= TC
        else:
            byte, self.next = self.next, None
            self.begin(byte, at)

    def end_received(self):
        byte, bit = self.line.popleft(), self.line_bit or self.bit()
        self.received_at = self.received_at + BITS * bit if self.line else NEVER
        if self["CR1"] & (UE | RE) != UE | RE:
            return
        if self["SR"] & RXNE:
            self["SR"] |= ORE
            return
        self["SR"] |= RXNE
        self.data = byte
        if abs(bit - self.bit()) * 25 > self.bit():
            # Its stop bit is not where it should be, and the others neither.
            self["SR"] |= FE
            self.data = byte ^ 0xFF

    def lines(self):
        cr1, sr = self["CR1"], self.read_SR()
        asks = sr & TXE and cr1 & TXEIE or sr & TC and cr1 & TCIE or sr & (RXNE | ORE) and cr1 & RXNEIE
        return (IRQ[self.NAME],) if asks else ()
