"""The three converters (RM0090, 13): one regular channel each, injected groups that a timer starts, and the analog watchdog. Each works for
itself; the modes in which they take turns are breaches."""

from .clock import HZ, NEVER
from .interrupts import IRQ
from .registers import Peripheral, Register

#: Clocks of sampling by SMP, to which 12 for the conversion come.
SAMPLING, CONVERSION = (3, 15, 28, 56, 84, 112, 144, 480), 12

#: What JEXTSEL chooses.
TIM1_CC4, TIM1_TRGO = 0, 1

AWD, EOC, JEOC, JSTRT, STRT = 1, 2, 4, 8, 16
EOCIE, AWDIE, JEOCIE, SCAN, AWDSGL, JAWDEN, AWDEN = (1 << bit for bit in (5, 6, 7, 8, 9, 22, 23))
ADON, JSWSTART, SWSTART = 1, 1 << 22, 1 << 30

#: Pins of the channels; 16 is the temperature of the chip, which the first converter alone has.
PINS = [f"PA{i}" for i in range(8)] + ["PB0", "PB1"] + [f"PC{i}" for i in range(6)]
TEMPERATURE = 16


class Adc(Peripheral):
    """One of them."""

    READ_SIZES = WRITE_SIZES = (4,)
    REGISTERS = {
        0x00: Register("SR", 0, rc_w0=0x3F),
        0x04: Register("CR1", 0x07C0_FFFF, known=AWDEN | JAWDEN | AWDSGL | SCAN | JEOCIE | AWDIE | EOCIE | 31),
        0x08: Register("CR2", 0x7F7F_0F03, known=SWSTART | 0x7F << 16 | ADON),
        0x0C: Register("SMPR1", 0x07FF_FFFF),
        0x10: Register("SMPR2", 0x3FFF_FFFF),
        0x24: Register("HTR", 0xFFF, 0xFFF),
        0x28: Register("LTR", 0xFFF),
        0x2C: Register("SQR1", 0x00FF_FFFF, known=0),
        0x30: Register("SQR2", 0x3FFF_FFFF, known=0),
        0x34: Register("SQR3", 0x3FFF_FFFF, known=0x1F),
        0x38: Register("JSQR", 0x003F_FFFF),
        0x4C: Register("DR", 0),
    } | {offset: register for i in range(4) for offset, register in (
        (0x14 + 4 * i, Register(f"JOFR{i + 1}", 0xFFF)), (0x3C + 4 * i, Register(f"JDR{i + 1}", 0)),
    )}  # fmt: skip

    def __init__(self, chip, number, block):
        self.NAME, self.number, self.block = f"ADC{number}", number, block
        self.CLOCK = (0x44, 7 + number)
        super().__init__(chip)

    def reset(self):
        super().reset()
        self.on_at = NEVER
        #: The end of what is converted, and what that is: a regular channel, or channels of the injected group that are still to come.
        self.done, self.regular, self.injected = NEVER, False, []
        #: A regular conversion that waits for the injected group, and begins anew behind it.
        self.waits = False

    # Conversions.

    def clock(self):
        """Core clocks in one of the converters': two of them are one of APB2."""
        return 4 * ((self.block["CCR"] >> 16 & 3) + 1)

    def duration(self, channel):
        time = self["SMPR1"] >> 3 * (channel - 10) & 7 if channel >= 10 else self["SMPR2"] >> 3 * channel & 7
        return self.clock() * (SAMPLING[time] + CONVERSION)

    def check_start(self, now):
        if not self["CR2"] & ADON or now < self.on_at:
            self.breach("started while it is off or not yet stable")
        if HZ // self.clock() > 36_000_000:
            self.breach(f"its clock has {HZ // self.clock()} Hz, and 36 MHz are the most")

    def check_channel(self, channel):
        if channel == TEMPERATURE and self.number == 1:
            if not self.block["CCR"] >> 23 & 1:
                self.breach("the temperature is asked for while its sensor is off")
        elif channel >= len(PINS) or self.number == 3 and (4 <= channel <= 9 or channel > 13):
            self.breach(f"channel {channel} has no pin")
        elif self.chip.gpio[PINS[channel][1]].mode(int(PINS[channel][2:])) != 3:
            self.breach(f"channel {channel} is converted while {PINS[channel]} is no analog pin")

    def level(self, at):
        """What the channel at hand had at the end of its sampling."""
        level = self.block.levels.get(self.channel, 0)
        return level(at - CONVERSION * self.clock()) if callable(level) else level

    def convert(self, channel, at):
        self.check_channel(channel)
        self.channel, self.done = channel, at + self.duration(channel)

    def begin_regular(self, at):
        self.check_start(at)
        if self.injected:
            self.waits = True
            return
        self.regular = True
        self["SR"] |= STRT
        self.convert(self["SQR3"] & 31, at)

    def begin_injected(self, at):
        """A trigger in the middle of a group is void; a regular conversion makes way and begins anew."""
        self.check_start(at)
        if self.injected:
            return
        jsqr, self.waits, self.regular = self["JSQR"], self.waits or self.regular, False
        length = (jsqr >> 20 & 3) + 1
        if length > 1 and not self["CR1"] & SCAN:
            self.breach(f"an injected group of {length} without SCAN")
        self.injected = [jsqr >> 5 * i & 31 for i in range(4 - length, 4)]
        self.length = length
        self["SR"] |= JSTRT
        self.convert(self.injected[0], at)

    def trigger(self, source, rising, at):
        """An edge of what may start the injected group."""
        edges = self["CR2"] >> 20 & 3
        if edges >> (not rising) & 1 and self["CR2"] >> 16 & 15 == source and self["CR2"] & ADON:
            while self.done <= at:
                self.event()
            self.begin_injected(at)

    def event(self):
        at, self.done = self.done, NEVER
        value = self.level(at)
        is_injected = bool(self.injected)
        self.watch(value, is_injected)
        if not is_injected:
            self.regular = False
            self["DR"] = value
            self["SR"] |= EOC
            return
        place = self.length - len(self.injected) + 1
        self[f"JDR{place}"] = value - self[f"JOFR{place}"] & 0xFFFF
        self.injected.pop(0)
        if self.injected:
            self.convert(self.injected[0], at)
            return
        self["SR"] |= JEOC
        if self.waits:
            self.waits = False
            self.begin_regular(at)

    def watch(self, value, is_injected):
        cr1 = self["CR1"]
        if cr1 & (JAWDEN if is_injected else AWDEN) and (not cr1 & AWDSGL or cr1 & 31 == self.channel):
            if not self["LTR"] <= value <= self["HTR"]:
                self["SR"] |= AWD

    # Registers.

    def write_CR1(self, value):
        self["CR1"] = value
        if value & (EOCIE | AWDIE | JEOCIE):
            self.chip.attend(self.block)

    def write_CR2(self, value):
        now = self.chip.now()
        if value >> 20 & 3 and value >> 16 & 15 not in (TIM1_CC4, TIM1_TRGO):
            self.breach(f"CR2 {value:#x}: a trigger other than TIM1's is not modelled")
        if value & ADON and not self["CR2"] & ADON:
            self.on_at = now + 3 * HZ // 1_000_000
        elif not value & ADON:
            self.done, self.regular, self.injected, self.waits = NEVER, False, [], False
        starts, self["CR2"] = value & (SWSTART | JSWSTART), value & ~(SWSTART | JSWSTART)
        if starts & SWSTART:
            self.begin_regular(now)
        if starts & JSWSTART:
            self.begin_injected(now)

    def write_JSQR(self, value):
        if self.injected:
            self.breach("JSQR written while its group is converted")
        self["JSQR"] = value

    def read_DR(self):
        self["SR"] &= ~EOC
        return self["DR"]

    def asks(self):
        return self["SR"] & ((self["CR1"] & EOCIE) >> 4 | (self["CR1"] & AWDIE) >> 6 | (self["CR1"] & JEOCIE) >> 5)


class Adcs(Peripheral):
    """Their block: each has 256 bytes, and behind them is what they share."""

    NAME = "ADC"
    READ_SIZES = WRITE_SIZES = (4,)
    CLOCK = (0x44, 8)
    REGISTERS = {0x304: Register("CCR", 0x00C3_EF1F, known=1 << 23 | 3 << 16)}

    def __init__(self, chip):
        self.adcs = []
        #: What lies at the channels, 0 to 4095, or a function of the moment that gives it. 16 is the temperature of the chip: 960 is 34 °C with
        #: the calibration in `engine.py`.
        self.levels = {14: 2048, TEMPERATURE: 960}
        super().__init__(chip)
        self.adcs = [Adc(chip, number, self) for number in (1, 2, 3)]

    def reset(self):
        super().reset()
        for adc in self.adcs:
            adc.reset()

    def has_clock(self):
        return self.chip.rcc["APB2ENR"] & 7 << 8

    def load(self, offset, size):
        return self.adcs[offset >> 8].load(offset & 0xFF, size) if offset < 0x300 else super().load(offset, size)

    def store(self, offset, size, value):
        if offset < 0x300:
            self.adcs[offset >> 8].store(offset & 0xFF, size, value)
        else:
            super().store(offset, size, value)

    def trigger(self, source, rising, at):
        """An edge of a timer's signal, for the injected groups that wait for it."""
        for adc in self.adcs:
            adc.trigger(source, rising, at)

    def next_event(self):
        first, second, third = self.adcs
        return min(first.done, second.done, third.done)

    def event(self):
        min(self.adcs, key=lambda adc: adc.done).event()

    def lines(self):
        return (IRQ["ADC"],) if any(adc.asks() for adc in self.adcs) else ()
