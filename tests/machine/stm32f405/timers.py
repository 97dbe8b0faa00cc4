"""The plain timers (RM0090, 18) on APB1, whose timers have 84 MHz: TIM3 gives the refills, TIM5 the time and the deadlines."""

from .clock import NEVER
from .interrupts import IRQ
from .registers import Peripheral, Register

#: Core clocks in a clock of these timers.
RATIO = 2


class Timer(Peripheral):
    """Counts upwards and overflows."""

    BITS = 16

    @classmethod
    def registers(cls):
        full = (1 << cls.BITS) - 1
        return {
            0x00: Register("CR1", 0x3FF),
            0x04: Register("CR2", 0xF8),
            0x08: Register("SMCR", 0xFFF7),
            0x0C: Register("DIER", 0x5F5F),
            0x10: Register("SR", 0, rc_w0=0x1E5F, keep=False),
            0x14: Register("EGR", 0x5F),
            0x18: Register("CCMR1", 0xFFFF),
            0x1C: Register("CCMR2", 0xFFFF),
            0x20: Register("CCER", 0xBBBB),
            0x24: Register("CNT", full),
            0x28: Register("PSC", 0xFFFF),
            0x2C: Register("ARR", full, full),
            0x34: Register("CCR1", full),
            0x38: Register("CCR2", full),
            0x3C: Register("CCR3", full),
            0x40: Register("CCR4", full),
        }

    #: What a timer has beside counting upwards, and what it is here.
    CR1, DIER = 0x85, 0

    def reset(self):
        super().reset()
        self.start, self.due = None, NEVER

    def only(self, name, value, bits=0):
        """Other bits of a register mean what is not modelled."""
        if value & ~bits:
            self.breach(f"{name} {value:#x}: this use of it is not modelled")
        self[name] = value

    def write_CR2(self, value):
        self.only("CR2", value)

    def write_SMCR(self, value):
        self.only("SMCR", value)

    def write_DIER(self, value):
        self.only("DIER", value, self.DIER)

    def write_CCMR1(self, value):
        self.only("CCMR1", value)

    def write_CCMR2(self, value):
        self.only("CCMR2", value)

    def write_CCER(self, value):
        self.only("CCER", value)

    def write_EGR(self, value):
        self.breach(f"EGR {value:#x} is not modelled")


class Tim3(Timer):
    """Overflows again and again, or counts the edges of an encoder (RM0090, 18.3.12): the level of the other line at an edge says the way."""

    NAME, CLOCK = "TIM3", (0x40, 1)
    DIER = 1
    REGISTERS = Timer.registers()
    #: Pins that can be channels 1 and 2.
    LINES = {"PA6": 1, "PB4": 1, "PC6": 1, "PA7": 2, "PB5": 2, "PC7": 2}
    #: By SMS: of which channels the edges count.
    ENCODER = {1: (2,), 2: (1,), 3: (1, 2)}

    def period(self):
        return RATIO * (self["PSC"] + 1) * (self["ARR"] + 1)

    def mode(self):
        return self["SMCR"] & 7

    def write_SMCR(self, value):
        if value & 7 not in (0, 1, 2, 3) or value & ~7:
            self.breach(f"SMCR {value:#x}: neither the internal clock nor an encoder")
        self["SMCR"] = value

    def write_CCMR1(self, value):
        self.only("CCMR1", value, 0x0101)

    def write_CCER(self, value):
        # Bits 1 and 5 invert the lines.
        self.only("CCER", value, 0x22)

    def write_CR1(self, value):
        self.only("CR1", value, self.CR1)
        if self.mode():
            self.due = NEVER
            if value & 1 and (self["CCMR1"] != 0x0101 or self["PSC"]):
                self.breach("an encoder without its two inputs, or behind a prescaler")
        elif not value & 1:
            self.due = NEVER
        elif self.due == NEVER:
            self.due = self.chip.now() + self.period()

    def read_CNT(self):
        if self.mode():
            return self["CNT"]
        if self.due == NEVER:
            return 0
        return self["ARR"] - (self.due - self.chip.now() - 1) // (RATIO * (self["PSC"] + 1))

    def line(self, channel):
        """The level of a line of the encoder, as CCER has it."""
        for pin, its in self.LINES.items():
            if its == channel and self.chip.gpio[pin[1]].function(int(pin[2:])) == 2:
                level = self.chip.pins.level(pin)
                if level is None:
                    self.breach(f"line {channel} of the encoder floats at {pin}")
                return (level or 0) ^ self["CCER"] >> (1 if channel == 1 else 5) & 1
        self.breach(f"line {channel} of the encoder has no pin")
        return 0

    def pin(self, pin, _level):
        channel = self.LINES.get(pin)
        if channel not in self.ENCODER.get(self.mode(), ()) or not self["CR1"] & 1:
            return
        if self.chip.gpio[pin[1]].function(int(pin[2:])) != 2:
            return
        # Channel 1 leads when it counts upwards.
        upwards = (self.line(1) == self.line(2)) == (channel == 2)
        count = self["CNT"] + (1 if upwards else -1)
        if not 0 <= count <= self["ARR"]:
            self["SR"] |= 1
            count %= self["ARR"] + 1
        self["CNT"] = count

    def next_event(self):
        return self.due

    def event(self):
        self.due += self.period()
        self["SR"] |= 1

    def lines(self):
        return (IRQ["TIM3"],) if self.r[0x10] & self.r[0x0C] & 1 else ()


class Tim5(Timer):
    """32 bits, free-running, with a compare on channel 1."""

    NAME, CLOCK = "TIM5", (0x40, 3)
    BITS, DIER = 32, 2

    REGISTERS = Timer.registers() | {
        offset: Register(name, 0xFFFF_FFFF, reset)
        for offset, name, reset in (
            (0x24, "CNT", 0), (0x2C, "ARR", 0xFFFF_FFFF), (0x34, "CCR1", 0), (0x38, "CCR2", 0), (0x3C, "CCR3", 0), (0x40, "CCR4", 0)
        )
    }

    def count(self, time):
        return (time - self.start) // RATIO & 0xFFFF_FFFF if self.start is not None else 0

    def read_CNT(self):
        return self.count(self.chip.now())

    def write_CR1(self, value):
        if value & 1 and self.start is None:
            self.start = self.chip.now()
        elif not value & 1 and self.start is not None:
            self.breach("the time is stopped")
        self.only("CR1", value, self.CR1)
        self.aim()

    def write_CCR1(self, value):
        self["CCR1"] = value
        self.aim()

    def aim(self):
        """When the counter comes to CCR1 next."""
        if self.start is None:
            return
        now = self.chip.now()
        ahead = (self["CCR1"] - self.count(now)) & 0xFFFF_FFFF or 1 << 32
        self.due = self.start + RATIO * ((now - self.start) // RATIO + ahead)

    def next_event(self):
        return self.due

    def event(self):
        self.due += RATIO << 32
        self["SR"] |= 2

    def lines(self):
        return (IRQ["TIM5"],) if self.r[0x10] & self.r[0x0C] & 2 else ()
