"""The chip: memory, peripherals, and the passing of time."""

import copy
from collections import namedtuple

from unicorn.arm_const import UC_ARM_REG_LR, UC_ARM_REG_PC

from .adc import Adcs
from .bxcan import Can
from .clock import NEVER
from .core import Core
from .cost import access
from .dma2 import Dma2
from .engine import CCM_SIZE, PARAMETERS_SIZE, RAM_SIZE, Engine
from .exti import Exti, Syscfg
from .flash import Flash
from .gpio import Gpio, Pins
from .image import Image
from .iwdg import Iwdg
from .rcc import Pwr, Rcc
from .registers import Breach
from .spi import Spi
from .system import Debug
from .tim1 import Tim1
from .tim2 import Tim2
from .timers import Tim3, Tim5
from .usart import Usart

Reset = namedtuple("Reset", "time why pc")


class Chip:
    """`flash`: what the parameter sectors hold from before, 32 KiB. `crystal`: whether it starts."""

    def __init__(self, elf, flash=None, crystal=True):
        #: A program has asked for a reset.
        self.reset_asked = False
        self.image = elf if isinstance(elf, Image) else Image(elf)
        self.crystal = crystal
        self.time, self.resets = 0, []
        self.first_breach = None
        self.locked_up = False
        self.is_off = False
        self.can = None
        self.parameters = flash or b"\xff" * PARAMETERS_SIZE
        self.pins = Pins(self)
        self.engine, self.core = Engine.take(self.image), None
        #: The next moment in which a peripheral does something of itself, unless something has been
        #: touched since.
        self.soon, self.stale = 0, True
        self.power_up()

    def copy(self):
        """Another chip in the same state."""
        twin = copy.deepcopy(self)
        twin.core.attach()
        return twin

    def leave(self):
        """Nobody uses it any more."""
        if self.core.cost is None:
            self.engine.leave()

    # Power and resets.

    def power_up(self):
        """What a power-on leaves in RAM is anything."""
        self.is_off = False
        self.engine.ram[:] = b"\xa5" * RAM_SIZE
        self.engine.ccm[:] = b"\x5a" * CCM_SIZE
        self.begin()

    def begin(self):
        self.engine.parameters[:] = self.parameters
        self.core = core = Core(self)
        self.connect_peripherals()
        self.stale = True
        core.start()

    def connect_peripherals(self):
        old, outer = self.can, (self.adc, self.tim1, self.spi, self.usart) if self.can else None
        outside = {port: gpio.outside for port, gpio in getattr(self, "gpio", {}).items()}
        self.peripherals = []
        self.rcc = Rcc(self)
        self.gpio = {port: Gpio(self, port) for port in "ABCDEFGHI"}
        for port, levels in outside.items():
            self.gpio[port].outside = levels
        self.flash, self.iwdg, self.pwr = Flash(self), Iwdg(self), Pwr(self)
        self.exti, self.syscfg, self.adc, self.debug = Exti(self), Syscfg(self), Adcs(self), Debug(self)
        self.dma2, self.tim1, self.tim2 = Dma2(self), Tim1(self), Tim2(self)
        self.tim3, self.tim5, self.can = Tim3(self), Tim5(self), Can(self)
        self.spi = {number: Spi(self, number) for number in (1, 2, 3)}
        self.usart = {number: Usart(self, number) for number in (1, 2, 3, 4)}
        if old is not None:
            adc, tim1, spi, usart = outer
            self.adc.levels, self.tim1.centre.on_change = adc.levels, tim1.centre.on_change
            for number, master in spi.items():
                self.spi[number].devices = master.devices
            for number, serial in usart.items():
                self.usart[number].on_byte, self.usart[number].line_bit = serial.on_byte, serial.line_bit
            self.can.on_frame, self.can.stats, self.can.bus_bit = old.on_frame, old.stats, old.bus_bit
            self.can.acknowledged, self.can.held = old.acknowledged, old.held
        blocks = {
            0x4002_3800: self.rcc, 0x4002_3C00: self.flash, 0x4000_3000: self.iwdg, 0x4000_7000: self.pwr, 0x4001_3C00: self.exti,
            0x4001_3800: self.syscfg, 0x4001_2000: self.adc, 0x4002_6400: self.dma2, 0x4001_0000: self.tim1, 0x4000_0000: self.tim2,
            0x4000_0400: self.tim3, 0x4000_0C00: self.tim5, 0x4000_6400: self.can,
        }  # fmt: skip
        blocks |= {0x4000_0000 + each.address: each for each in (*self.spi.values(), *self.usart.values())}
        blocks |= {0x4002_0000 + 0x400 * i: gpio for i, gpio in enumerate(self.gpio.values())}
        self.blocks = {address - 0x4000_0000 >> 10: peripheral for address, peripheral in blocks.items()}
        self.peripherals = list(blocks.values())
        # The converters behind the timer, which starts them.
        self.with_events = [self.iwdg, self.tim3, self.tim5, self.tim1, self.adc, self.can, self.rcc]
        self.with_lines = [self.exti, self.tim1, self.tim2, self.tim3, self.tim5, self.can]

    def attend(self, peripheral):
        """A peripheral that not every image has is looked at from now on."""
        for those in (self.with_events, self.with_lines):
            if peripheral not in those:
                those.append(peripheral)

    def reset(self, why):
        """A reset of the chip; RAM keeps what it has."""
        self.resets.append(Reset(self.time, why, self.core.pc))
        self.parameters = bytes(self.engine.parameters)
        for port, gpio in self.gpio.items():
            for pin in gpio.outputs():
                self.pins.note(f"P{port}{pin}", None)
        self.begin()

    def cut_power_now(self):
        """In the middle of an operation of the flash: nothing that follows happens."""
        self.parameters = bytes(self.engine.parameters)
        self.is_off = True
        self.core.uc.emu_stop()

    def cycle_power(self):
        if not self.is_off:
            self.parameters = bytes(self.engine.parameters)
        self.power_up()

    # Breaches.

    def breach(self, text):
        """What the manuals forbid; the first one is told when the slice is over."""
        if self.first_breach is None:
            uc = self.core.uc
            pc, lr = uc.reg_read(UC_ARM_REG_PC), uc.reg_read(UC_ARM_REG_LR)
            self.first_breach = (text, pc, lr)

    def check(self):
        if self.first_breach is not None:
            text, pc, lr = self.first_breach
            raise Breach(f"{text}\n  at {self.image.where(pc)}\n  from {self.image.where(lr)}")

    # The buses.

    def load(self, offset, size):
        self.core.accesses += 1
        self.stale = True
        if self.core.cost is not None:
            self.core.cost.extra += access(offset)
        peripheral = self.blocks.get(offset >> 10)
        # What RCC shows changes by its events alone.
        self.core.unsteady += peripheral is not self.rcc
        if peripheral is None:
            self.breach(f"{0x4000_0000 + offset:#x} read, which is not modelled")
            return 0
        return peripheral.load(offset & 0x3FF, size)

    def store(self, offset, size, value):
        self.core.accesses += 1
        self.stale = True
        if self.core.cost is not None:
            self.core.cost.extra += access(offset)
        self.core.unsteady += 1
        peripheral = self.blocks.get(offset >> 10)
        if peripheral is None:
            self.breach(f"{0x4000_0000 + offset:#x} written with {value:#x}, which is not modelled")
        else:
            peripheral.store(offset & 0x3FF, size, value)

    def load_bit(self, offset):
        """A bit of a peripheral as a word of its own (PM0214, 2.2.5)."""
        return self.load(offset >> 5 & ~3, 4) >> (offset >> 2 & 31) & 1

    def store_bit(self, offset, value):
        word, bit = offset >> 5 & ~3, offset >> 2 & 31
        self.store(word, 4, self.load(word, 4) & ~(1 << bit) | (value & 1) << bit)

    # Time.

    def now(self):
        return self.time + self.core.since_slice()

    def step(self, until):
        """Runs a slice, or sleeps to the next event."""
        core = self.core
        if self.stale:
            self.look_ahead()
        upcoming = min(self.soon, core.system.ticks_at, until)
        if core.sleeping or core.loops or core.is_stopped:
            core.shares.add(None, max(0, upcoming - self.time))
            self.time = max(self.time, upcoming)
        else:
            self.time += core.run_slice(upcoming - self.time)
            self.time, core.stall = self.time + core.stall, 0
        if self.first_breach is not None:
            self.check()
        if self.is_off:
            return
        if self.reset_asked:
            self.reset_asked = False
            return self.reset("software")
        if self.stale or self.time >= self.soon or self.time >= core.system.ticks_at:
            self.pass_events(core)
            if core is not self.core or core.is_stopped:
                return
            core.take_lines()
        if core.system.pending:
            core.deliver()

    def look_ahead(self):
        self.soon = min([peripheral.next_event() for peripheral in self.with_events])
        self.stale = False

    def pass_events(self, core):
        """What is due happens. An event changes its own peripheral's next one alone."""
        time, soon = self.time, NEVER
        for peripheral in self.with_events:
            at = peripheral.next_event()
            while at <= time:
                peripheral.event()
                if core is not self.core:
                    return
                if peripheral is self.rcc:
                    # The only one that a loop may look at and still be one (`load`).
                    core.loops, core.seen, core.whole = False, {}, None
                at = peripheral.next_event()
            if at < soon:
                soon = at
        while core.system.ticks_at <= time:
            core.system.tick(time)
        self.soon, self.stale = soon, False

    def run(self, clocks, is_over=lambda: False):
        """Lets so much time pass, or less if something is over."""
        end = self.time + clocks
        self.stale, self.engine.chip = True, self
        if not self.core.is_stopped:
            # What has come from outside meanwhile wakes a core that sleeps, now and not at the next event.
            self.core.take_lines()
            self.core.deliver()
        while self.time < end and not is_over() and not self.is_off:
            self.step(end)
        return is_over()
