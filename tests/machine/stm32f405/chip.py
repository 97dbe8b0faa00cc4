"""The chip: memory, peripherals, and the passing of time."""

import struct
from collections import namedtuple

from unicorn.arm_const import UC_ARM_REG_LR, UC_ARM_REG_PC

from .adc import Adc
from .bxcan import Can
from .clock import NEVER
from .core import Core
from .cost import access
from .dma2 import Dma2
from .exti import Exti, Syscfg
from .flash import BASE, SIZE, Flash
from .gpio import Gpio, Pins
from .image import Image
from .iwdg import Iwdg
from .rcc import Pwr, Rcc
from .registers import Breach
from .system import Debug
from .tim1 import Tim1
from .tim2 import Tim2
from .timers import Tim3, Tim5

RAM, RAM_SIZE = 0x2000_0000, 0x2_0000
CCM, CCM_SIZE = 0x1000_0000, 0x1_0000
SYSTEM_MEMORY = 0x1FFF_7000
#: A serial number, 1 MiB of flash, and what the temperature sensor reads at 30 °C and 110 °C.
UNIQUE_ID = bytes.fromhex("2a003b000d51353238333733")
CALIBRATION = struct.pack("<HH", 943, 1194)

PARAMETERS, PARAMETERS_SIZE = 0x0800_8000, 0x8000

Reset = namedtuple("Reset", "time why where")


class Chip:
    """`flash`: what the parameter sectors hold from before, 32 KiB. `crystal`: whether it starts."""

    def __init__(self, elf, flash=None, crystal=True):
        self.image = elf if isinstance(elf, Image) else Image(elf)
        self.crystal = crystal
        self.option_bytes = 0x0FFF_AAEC
        self.time, self.resets = 0, []
        self.first_breach = None
        self.locked_up = False
        self.is_off = False
        self.can = None
        self.parameters = flash or b"\xff" * PARAMETERS_SIZE
        self.pins = Pins(self)
        self.power_up()

    # Power and resets.

    def power_up(self):
        """What a power-on leaves in RAM is anything."""
        self.is_off = False
        self.begin(b"\xa5" * RAM_SIZE, b"\x5a" * CCM_SIZE)

    def begin(self, ram, ccm):
        self.core = core = Core(self)
        uc = core.uc
        for address, size in ((BASE, SIZE), (CCM, CCM_SIZE), (RAM, RAM_SIZE), (SYSTEM_MEMORY, 0x1000)):
            uc.mem_map(address, size)
        uc.mem_write(BASE, b"\xff" * SIZE)
        for address, data in self.image.segments:
            uc.mem_write(address, data)
        uc.mem_write(PARAMETERS, self.parameters)
        uc.mem_write(SYSTEM_MEMORY + 0xA10, UNIQUE_ID)
        uc.mem_write(SYSTEM_MEMORY + 0xA22, struct.pack("<H", 1024))
        uc.mem_write(SYSTEM_MEMORY + 0xA2C, CALIBRATION)
        uc.mem_write(RAM, ram)
        uc.mem_write(CCM, ccm)
        self.connect_peripherals()
        core.connect()
        core.start()

    def connect_peripherals(self):
        old = self.can
        outside = {port: gpio.outside for port, gpio in getattr(self, "gpio", {}).items()}
        self.peripherals = []
        self.rcc = Rcc(self)
        self.gpio = {port: Gpio(self, port) for port in "ABCDEFGHI"}
        for port, levels in outside.items():
            self.gpio[port].outside = levels
        self.flash, self.iwdg, self.pwr = Flash(self), Iwdg(self), Pwr(self)
        self.exti, self.syscfg, self.adc, self.debug = Exti(self), Syscfg(self), Adc(self), Debug(self)
        self.dma2, self.tim1, self.tim2 = Dma2(self), Tim1(self), Tim2(self)
        self.tim3, self.tim5, self.can = Tim3(self), Tim5(self), Can(self)
        if old is not None:
            self.can.on_frame, self.can.stats, self.can.bus_bit = old.on_frame, old.stats, old.bus_bit
            self.can.acknowledged = old.acknowledged
        blocks = {
            0x4002_3800: self.rcc, 0x4002_3C00: self.flash, 0x4000_3000: self.iwdg, 0x4000_7000: self.pwr, 0x4001_3C00: self.exti,
            0x4001_3800: self.syscfg, 0x4001_2000: self.adc, 0x4002_6400: self.dma2, 0x4001_0000: self.tim1, 0x4000_0000: self.tim2,
            0x4000_0400: self.tim3, 0x4000_0C00: self.tim5, 0x4000_6400: self.can,
        }  # fmt: skip
        blocks |= {0x4002_0000 + 0x400 * i: gpio for i, gpio in enumerate(self.gpio.values())}
        self.blocks = {address - 0x4000_0000 >> 10: peripheral for address, peripheral in blocks.items()}
        self.peripherals = list(blocks.values())
        self.with_events = [self.iwdg, self.adc, self.tim3, self.tim5, self.tim1, self.can, self.rcc]
        self.with_lines = [self.exti, self.tim1, self.tim2, self.tim3, self.tim5, self.can]

    def reset(self, why):
        """A reset of the chip; RAM keeps what it has."""
        uc = self.core.uc
        self.resets.append(Reset(self.time, why, self.image.where(self.core.pc)))
        self.parameters = bytes(uc.mem_read(PARAMETERS, PARAMETERS_SIZE))
        ram, ccm = bytes(uc.mem_read(RAM, RAM_SIZE)), bytes(uc.mem_read(CCM, CCM_SIZE))
        for pin, level in (("PA2", None), ("PC2", None)):
            self.pins.note(pin, level)
        self.begin(ram, ccm)

    def cut_power_now(self):
        """In the middle of an operation of the flash: nothing that follows happens."""
        self.parameters = bytes(self.core.uc.mem_read(PARAMETERS, PARAMETERS_SIZE))
        self.is_off = True
        self.core.uc.emu_stop()

    def cycle_power(self):
        if not self.is_off:
            self.parameters = bytes(self.core.uc.mem_read(PARAMETERS, PARAMETERS_SIZE))
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
        if self.core.cost is not None:
            self.core.cost.extra += access(offset)
        self.core.unsteady += 1
        peripheral = self.blocks.get(offset >> 10)
        if peripheral is None:
            self.breach(f"{0x4000_0000 + offset:#x} written with {value:#x}, which is not modelled")
        else:
            peripheral.store(offset & 0x3FF, size, value)

    def read(self, _uc, offset, size, _):
        return self.load(offset, size)

    def write(self, _uc, offset, size, value, _):
        self.store(offset, size, value & (1 << 8 * size) - 1)

    def read_bit(self, _uc, offset, _size, _):
        return self.load(offset >> 5 & ~3, 4) >> (offset >> 2 & 31) & 1

    def write_bit(self, _uc, offset, _size, value, _):
        word, bit = offset >> 5 & ~3, offset >> 2 & 31
        self.store(word, 4, self.load(word, 4) & ~(1 << bit) | (value & 1) << bit)

    def is_code(self, address):
        return BASE <= address < BASE + SIZE

    # Time.

    def now(self):
        return self.time + self.core.since_slice()

    def step(self, until):
        """Runs a slice, or sleeps to the next event."""
        core = self.core
        upcoming = min(min(p.next_event() for p in self.with_events), core.system.ticks_at, until)
        if core.sleeping or core.loops or core.is_stopped:
            core.shares.add(None, max(0, upcoming - self.time))
            self.time = max(self.time, upcoming)
        else:
            self.time += core.run_slice(upcoming - self.time)
            self.time, core.stall = self.time + core.stall, 0
        self.check()
        if self.is_off:
            return
        if core.wants_reset:
            return self.reset(core.wants_reset)
        while self.pass_events(core):
            pass
        if core is not self.core or core.is_stopped:
            return
        core.take_lines()
        if core.system.pending:
            core.deliver()

    def pass_events(self, core):
        due = False
        for peripheral in self.with_events:
            if peripheral.next_event() <= self.time:
                peripheral.event()
                if peripheral is self.rcc:
                    # The only one that a loop may look at and still be one (`load`).
                    core.loops, core.seen = False, {}
                due = core is self.core
                if not due:
                    return False
        if core.system.ticks_at <= self.time:
            core.system.tick(self.time)
            due = True
        return due

    def run(self, clocks, is_over=lambda: False):
        """Lets so much time pass, or less if something is over."""
        end = self.time + clocks
        if not self.core.is_stopped:
            # What has come from outside meanwhile wakes a core that sleeps, now and not at the next event.
            self.core.take_lines()
            self.core.deliver()
        while self.time < end and not is_over() and not self.is_off:
            self.step(end)
        return is_over()
