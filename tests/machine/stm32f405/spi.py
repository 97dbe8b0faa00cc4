"""The SPI masters (RM0090, 28): words of 8 or 16 bits, full duplex, with chip selects that are plain outputs. Other uses are breaches."""

from .clock import NEVER
from .interrupts import IRQ
from .registers import Peripheral, Register

CPHA, CPOL, MSTR, SPE, SSI, SSM, DFF = 1, 2, 4, 1 << 6, 1 << 8, 1 << 9, 1 << 11
RXNE, TXE, OVR, BSY = 1, 2, 1 << 6, 1 << 7
RXNEIE, TXEIE = 1 << 6, 1 << 7
#: What must not change while it is on.
SETTINGS = CPHA | CPOL | MSTR | 7 << 3 | DFF

#: By number: the offset of the block, where RCC has its clock, core clocks in one of its bus, the alternate function, and the pins of clock, input
#: and output.
WHICH = {
    1: (0x1_3000, (0x44, 12), 2, 5, (("PA5", "PB3"), ("PA6", "PB4"), ("PA7", "PB5"))),
    2: (0x3800, (0x40, 14), 4, 5, (("PB10", "PB13"), ("PB14", "PC2"), ("PB15", "PC3"))),
    3: (0x3C00, (0x40, 15), 4, 6, (("PB3", "PC10"), ("PB4", "PC11"), ("PB5", "PC12"))),
}

#: Pins that it drives, with their alternate function.
OUTPUTS = {(pin, function) for _, _, _, function, (clocks, _, outputs) in WHICH.values() for pin in (*clocks, *outputs)}


class Spi(Peripheral):
    """`devices`: what hangs on its wires. Each has the pin of its chip select (`select`, low is chosen), the mode of the clock that it
    wants (`mode`, CPOL and CPHA as one number), the fastest one in Hz (`fastest`) and the bits of its words (`bits`); `exchange(word)` gives what
    it sends while it receives a word."""

    READ_SIZES = (2, 4)
    WRITE_SIZES = (1, 2, 4)
    REGISTERS = {
        0x00: Register("CR1", 0xFFFF, known=SETTINGS | SPE | SSI | SSM),
        0x04: Register("CR2", 0xF7, known=RXNEIE | TXEIE),
        0x08: Register("SR", 0, TXE, keep=False),
        0x0C: Register("DR", 0xFFFF),
    }

    def __init__(self, chip, number):
        self.NAME, self.number, self.devices = f"SPI{number}", number, []
        self.address, self.CLOCK, self.ratio, self.function, self.pins = WHICH[number]
        super().__init__(chip)

    def reset(self):
        super().reset()
        #: The end of the word that is under way, that word, and the one that waits behind it.
        self.done, self.word, self.next = NEVER, None, None
        self.received = 0
        #: The status has been read with its overrun, which reading the data clears then.
        self.overrun_seen = False

    def store(self, offset, size, value):
        if size == 1 and (offset != 0x0C or self["CR1"] & DFF):
            self.breach(f"offset {offset:#x} written with 1 bytes")
        super().store(offset, size, value)

    def load(self, offset, size):
        if size == 1 and offset == 0x0C and not self["CR1"] & DFF:
            size = 2
        return super().load(offset, size)

    def write_CR1(self, value):
        old = self["CR1"]
        if old & value & SPE and (old ^ value) & SETTINGS:
            self.breach(f"CR1 {value:#x}: its settings change while it is on")
        if old & SPE and not value & SPE and self.word is not None:
            self.breach("switched off in the middle of a word")
        if value & SPE and not old & SPE:
            self.check(value)
            self.chip.attend(self)
        self["CR1"] = value

    def check(self, cr1):
        if not cr1 & MSTR or cr1 & (SSM | SSI) != SSM | SSI:
            self.breach(f"CR1 {cr1:#x}: another use than a master with SSM and SSI is not modelled")
        for pins, what in zip(self.pins, ("clock", "input", "output")):
            if sum(self.chip.gpio[pin[1]].function(int(pin[2:])) == self.function for pin in pins) != 1:
                self.breach(f"it has not one pin for its {what}: {' or '.join(pins)} with function {self.function}")

    # Words.

    def bits(self):
        return 16 if self["CR1"] & DFF else 8

    def bit(self):
        """Core clocks of a bit."""
        return self.ratio * (2 << (self["CR1"] >> 3 & 7))

    def write_DR(self, value):
        if not self["CR1"] & SPE:
            return self.breach("DR written while it is off")
        value &= (1 << self.bits()) - 1
        if self.word is None:
            self.begin(value, self.chip.now())
        elif self.next is None:
            self.next = value
        else:
            self.breach("DR written while a word waits in it")

    def begin(self, word, at):
        self.word, self.done = word, at + self.bits() * self.bit()

    def read_DR(self):
        self["SR"] &= ~RXNE
        if self.overrun_seen:
            self["SR"] &= ~OVR
            self.overrun_seen = False
        return self.received

    def read_SR(self):
        self.overrun_seen = bool(self["SR"] & OVR)
        return self["SR"] & ~TXE | (self.next is None) << 1 | (self.word is not None) << 7

    def device(self):
        """Who is chosen."""
        chosen = [device for device in self.devices if self.chip.pins.level(device.select) == 0]
        if len(chosen) > 1:
            self.breach(f"{' and '.join(device.select for device in chosen)} choose two devices at once")
        return chosen[0] if chosen else None

    def exchange(self, word):
        device = self.device()
        if device is None:
            # Nobody drives the input.
            return (1 << self.bits()) - 1
        mode, hz = self["CR1"] & 3, 168_000_000 // self.bit()
        if mode != device.mode or hz > device.fastest or self.bits() != device.bits:
            self.breach(f"mode {mode}, {hz} Hz, {self.bits()} bits, where {device.select} has {device.mode}, {device.fastest} and {device.bits}")
        return device.exchange(word)

    def next_event(self):
        return self.done

    def event(self):
        at, self.done = self.done, NEVER
        received, self.word = self.exchange(self.word), None
        if self["SR"] & RXNE:
            self["SR"] |= OVR
        else:
            self.received = received
            self["SR"] |= RXNE
        if self.next is not None:
            word, self.next = self.next, None
            self.begin(word, at)

    def lines(self):
        enabled = self["CR2"]
        asks = enabled & RXNEIE and self["SR"] & RXNE or enabled & TXEIE and self.next is None
        return (IRQ[self.NAME],) if asks else ()
