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

    def reset(self):
        super().reset()
        self.start, self.due = None, NEVER


class Tim3(Timer):
    """Overflows again and again."""

    NAME, CLOCK = "TIM3", (0x40, 1)
    REGISTERS = Timer.registers()

    def period(self):
        return RATIO * (self["PSC"] + 1) * (self["ARR"] + 1)

    def write_CR1(self, value):
        if value & 1 and not self["CR1"] & 1:
            self.due = self.chip.now() + self.period()
        if not value & 1:
            self.due = NEVER
        self["CR1"] = value

    def next_event(self):
        return self.due

    def event(self):
        self.due += self.period()
        self["SR"] |= 1

    def lines(self):
        yield IRQ["TIM3"], self["SR"] & self["DIER"] & 1


class Tim5(Timer):
    """32 bits, free-running, with a compare on channel 1."""

    NAME, CLOCK = "TIM5", (0x40, 3)
    BITS = 32

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
        self["CR1"] = value
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
        yield IRQ["TIM5"], self["SR"] & self["DIER"] & 2
