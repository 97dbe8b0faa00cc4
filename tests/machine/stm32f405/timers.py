"""The plain timers (RM0090, 18) on APB1, whose timers have 84 MHz: TIM3 gives the refills, TIM5 the time and the deadlines."""

from .clock import NEVER
from .interrupts import IRQ
from .registers import Peripheral, Register

#: Core clocks in a clock of these timers.
RATIO = 2


def registers(bits, **known):
    """The registers of a timer with a counter of so many bits; `known`: what of them is modelled.
    `CR1` always has the enable, URS and the preload."""
    full = (1 << bits) - 1
    resets = {"ARR": full}
    table = {
        "CR1": 0x3FF, "CR2": 0xF8, "SMCR": 0xFFF7, "DIER": 0x5F5F, "SR": None, "EGR": 0x5F, "CCMR1": 0xFFFF, "CCMR2": 0xFFFF, "CCER": 0xBBBB, "CNT": full,
        "PSC": 0xFFFF, "ARR": full, None: None, "CCR1": full, "CCR2": full, "CCR3": full, "CCR4": full,
    }  # fmt: skip
    known = {"CR1": 0x85} | known
    return {
        4 * i: Register(name, 0, rc_w0=0x1E5F, keep=False) if name == "SR" else Register(name, its, resets.get(name, 0), known=known.get(name, 0))
        for i, (name, its) in enumerate(table.items())
        if name is not None
    }


class Timer(Peripheral):
    """Counts upwards and overflows."""

    def reset(self):
        super().reset()
        self.start, self.due = None, NEVER


class Tim3(Timer):
    """Overflows again and again, or counts the edges of an encoder (RM0090, 18.3.12): the level of the other line at an edge says the way. Channel 4
    captures the count at a rising edge, the index of an encoder."""

    NAME, CLOCK = "TIM3", (0x40, 1)
    REGISTERS = registers(16, SMCR=0xFFF7, DIER=1, CCMR1=0xF1F1, CCMR2=0xF100, CCER=0x1022, CCR4=0xFFFF, CNT=0xFFFF, PSC=0xFFFF, ARR=0xFFFF)
    #: Pins that can be channels 1 and 2.
    LINES = {"PA6": 1, "PB4": 1, "PC6": 1, "PA7": 2, "PB5": 2, "PC7": 2}
    INDEX = "PC9"
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

    def write_CR1(self, value):
        self["CR1"] = value
        if self.mode():
            self.due = NEVER
            if value & 1 and (self["CCMR1"] & 0x0303 != 0x0101 or self["PSC"]):
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
        """The level of a line of the encoder; bits 1 and 5 of CCER invert them."""
        for pin, its in self.LINES.items():
            if its == channel and self.chip.gpio[pin[1]].function(int(pin[2:])) == 2:
                level = self.chip.pins.level(pin)
                if level is None:
                    self.breach(f"line {channel} of the encoder floats at {pin}")
                return (level or 0) ^ self["CCER"] >> (1 if channel == 1 else 5) & 1
        self.breach(f"line {channel} of the encoder has no pin")
        return 0

    def write_CCMR2(self, value):
        if self["CCER"] & 0x1000:
            self.breach("CCMR2 is written while channel 4 is on")
        self["CCMR2"] = value

    def capture(self):
        if self["SR"] & 1 << 4:
            self["SR"] |= 1 << 12
        self["CCR4"] = self["CNT"]
        self["SR"] |= 1 << 4

    def read_CCR4(self):
        self["SR"] &= ~(1 << 4)
        return self["CCR4"]

    def pin(self, pin, level):
        if pin == self.INDEX and level and self["CCER"] & 0x1000 and self["CCMR2"] & 0x300 == 0x100 and self.chip.gpio["C"].function(9) == 2:
            self.capture()
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
    REGISTERS = registers(32, DIER=2, CCR1=0xFFFF_FFFF)

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
        return (IRQ["TIM5"],) if self.r[0x10] & self.r[0x0C] & 2 else ()
