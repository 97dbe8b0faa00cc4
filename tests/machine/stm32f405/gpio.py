"""General-purpose pins (RM0090, 8), and who drives them."""

import random

from .pwm import OUTPUTS as BRIDGES
from .registers import Peripheral, Register, read_only
from .spi import OUTPUTS as WIRES
from .usart import OUTPUTS as SERIAL

INPUT, OUTPUT, ALTERNATE, ANALOG = range(4)

#: Pins that a peripheral drives, with its alternate function: TIM1's outputs, SPI, serial lines, CAN transmit.
OUTPUTS = {(pin, 1) for pin in BRIDGES} | WIRES | SERIAL | {("PB9", 9)}


class Gpio(Peripheral):
    WRITE_SIZES = (1, 2, 4)
    REGISTERS = {
        0x00: Register("MODER"),
        0x04: Register("OTYPER", 0xFFFF),
        0x08: Register("OSPEEDR"),
        0x0C: Register("PUPDR"),
        0x10: read_only("IDR"),
        0x14: Register("ODR", 0xFFFF),
        0x18: Register("BSRR"),
        0x20: Register("AFRL"),
        0x24: Register("AFRH"),
    }
    #: MODER, OSPEEDR and PUPDR after a reset: the pins of the debugger.
    RESETS = {"A": (0xA800_0000, 0x0C00_0000, 0x6400_0000), "B": (0x280, 0xC0, 0x100)}

    def __init__(self, chip, port):
        self.port, self.NAME = port, f"GPIO{port}"
        self.CLOCK = (0x30, ord(port) - ord("A"))
        self.outside = {}
        #: What a pin that floats reads as.
        self.noise = random.Random(port)
        #: The pins that are high, and those that float, as long as nothing changes them.
        self.seen = None
        super().__init__(chip)

    def reset(self):
        super().reset()
        self.seen = None
        moder, ospeedr, pupdr = self.RESETS.get(self.port, (0, 0, 0))
        self["MODER"], self["OSPEEDR"], self["PUPDR"] = moder, ospeedr, pupdr

    def mode(self, pin):
        return self["MODER"] >> 2 * pin & 3

    def outputs(self):
        """The pins that the output register drives."""
        return [pin for pin in range(16) if self.mode(pin) == OUTPUT]

    def function(self, pin):
        """The alternate function that has the pin, or None."""
        if self.mode(pin) != ALTERNATE:
            return None
        return self["AFRH" if pin > 7 else "AFRL"] >> 4 * (pin & 7) & 15

    def level(self, pin):
        """What lies at the pin: 0, 1, or None where nobody drives or pulls it."""
        mode = self.mode(pin)
        if mode == OUTPUT:
            return self["ODR"] >> pin & 1
        if pin in self.outside:
            return self.outside[pin]
        return {1: 1, 2: 0}.get(self["PUPDR"] >> 2 * pin & 3)

    def is_driven(self, pin):
        """Whether the chip drives the pin, by its output register or by a peripheral."""
        if self["OTYPER"] >> pin & 1:
            return False
        return self.mode(pin) == OUTPUT or (f"P{self.port}{pin}", self.function(pin)) in OUTPUTS

    def drive(self, pin, level):
        """A level from outside; None: nothing drives the pin any more."""
        self.seen = None
        if level is None:
            self.outside.pop(pin, None)
        else:
            if self.is_driven(pin):
                self.breach(f"P{self.port}{pin} is driven from outside and by the chip")
            self.outside[pin] = level

    def store(self, offset, size, value):
        self.seen = None
        super().store(offset, size, value)

    def read_IDR(self):
        """A pin that floats reads as anything; who uses it, is told (`Pins.floats`), or does what
        it should not."""
        if self.seen is None:
            levels = [self.level(pin) if self.mode(pin) != ANALOG else 0 for pin in range(16)]
            self.seen = sum(1 << pin for pin in range(16) if levels[pin]), sum(1 << pin for pin in range(16) if levels[pin] is None)
        high, floating = self.seen
        return high | floating & self.noise.getrandbits(16)

    def write_BSRR(self, value):
        self.set_odr(self["ODR"] & ~(value >> 16) | value & 0xFFFF)

    def write_ODR(self, value):
        self.set_odr(value)

    def set_odr(self, value):
        changed = self["ODR"] ^ value
        self["ODR"] = value
        for pin in range(16):
            if changed >> pin & 1 and self.mode(pin) == OUTPUT:
                self.chip.pins.note(f"P{self.port}{pin}", value >> pin & 1)

    def write_MODER(self, value):
        old = self["MODER"]
        self["MODER"] = value
        for pin in range(16):
            if (old ^ value) >> 2 * pin & 3:
                self.changed_mode(pin)

    def changed_mode(self, pin):
        mode = self.mode(pin)
        if pin in self.outside and self.is_driven(pin):
            self.breach(f"P{self.port}{pin} becomes an output and is driven from outside")
        self.chip.pins.note(f"P{self.port}{pin}", self.level(pin) if mode == OUTPUT else None)

    def widen(self, word, byte, size, value):
        # A narrow write to BSRR sets and resets nothing of the rest.
        return value << 8 * byte if word == 0x18 else super().widen(word, byte, size, value)


class Pins:
    """What has become of the outputs, and the levels from outside."""

    def __init__(self, chip):
        self.chip = chip
        self.log = []
        #: Who is told of the levels of an output, by pin.
        self.watchers = {}

    def note(self, pin, level):
        """An output has a new level, or the pin is none any more (None)."""
        self.log.append((self.chip.now(), pin, level))
        if pin in self.watchers:
            self.watchers[pin](level)

    def floats(self, pin, what):
        """Something looks at a pin: it is told where that has no level."""
        port, number = pin[1], int(pin[2:])
        if self.chip.gpio[port].level(number) is None:
            self.chip.breach(f"{what} is at {pin}, which floats")

    def level(self, pin):
        return self.chip.gpio[pin[1]].level(int(pin[2:]))

    def drive(self, pin, level):
        """Puts a level on a pin from outside."""
        port, number = self.chip.gpio[pin[1]], int(pin[2:])
        before = port.level(number)
        port.drive(number, level)
        if level is None or before == level:
            return
        self.chip.exti.edge(pin[1], number, level)
        self.chip.tim1.pin(pin, level)
        self.chip.tim2.pin(pin, level)
        self.chip.tim3.pin(pin, level)

    def changes(self, pin, since=0):
        """The times and levels of an output from a moment on."""
        return [(time, level) for time, name, level in self.log if name == pin and time >= since]
