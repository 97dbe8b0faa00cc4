"""The flash controller (RM0090, 3): keys, erasing, programming. While it works, the core stands still: its code lies in the same flash."""

import random

from .clock import HZ, MS, US
from .engine import FLASH as BASE
from .engine import PARAMETERS, PARAMETERS_SIZE
from .registers import Peripheral, Register

KEYS = [0x4567_0123, 0xCDEF_89AB]
LOCK, STRT, PG, SER, MER = 1 << 31, 1 << 16, 1, 2, 4
ERRORS = 0xF2

#: Begin and size of each sector.
SECTORS = [(i * 0x4000, 0x4000) for i in range(4)] + [(0x10000, 0x10000)] + [(0x20000 * i, 0x20000) for i in range(1, 8)]

#: Typical times (data sheet, 5.3.12): programming, and erasing 16 KiB by PSIZE; larger sectors in proportion.
PROGRAM = 16 * US
ERASE_16K = {0: 400 * MS, 1: 300 * MS, 2: 250 * MS}
#: The most that they take: so many times as long.
SLOWEST_PROGRAM, SLOWEST_ERASE = 6.25, 2


class Flash(Peripheral):
    NAME = "FLASH"
    WRITE_SIZES = (1, 2, 4)
    REGISTERS = {
        0x00: Register("ACR", 0x1F07, 0, keep=False),
        0x04: Register("KEYR"),
        0x0C: Register("SR", 0, rc_w1=ERRORS | 1, keep=False),
        0x10: Register("CR", 0x8101_037F | 1 << 24, LOCK, known=LOCK | STRT | 3 << 8 | 0xF << 3 | SER | PG),
    }

    def __init__(self, chip):
        self.keys = []
        self.erased, self.programmed = [], 0
        #: In the middle of which operation from now on the power goes away: any, or erasing one.
        #: What has become of its bits by then: of those that become 1, this part.
        self.operations_until_cut = self.erases_until_cut = None
        self.erased_part, self.chance = 0.5, random.Random(1)
        self.is_slow = False
        super().__init__(chip)

    def write_ACR(self, value):
        if value >> 12 & 1 and value >> 10 & 1 or value >> 11 & 1 and value >> 9 & 1:
            self.breach("a cache is reset while it is on")
        self["ACR"] = value

    def write_KEYR(self, value):
        self.keys.append(value)
        if self.keys[-2:] == KEYS:
            self["CR"] &= ~LOCK
        elif value not in KEYS:
            self.breach("a wrong key: the flash is locked until a reset")

    def reset(self):
        super().reset()
        self.keys = []

    def write_CR(self, value):
        if self["CR"] & LOCK:
            return self.breach("CR written while locked")
        self["CR"] = value & ~STRT
        if value & LOCK:
            self.keys = []
        if not value & STRT:
            return
        if value & (SER | MER | PG) != SER:
            return self.breach(f"CR {value:#x}: neither one sector nor only that")
        number = value >> 3 & 15
        begin, size = SECTORS[number]
        if number not in (2, 3):
            return self.breach(f"sector {number}, which is not for parameters, is erased")
        flash = self.chip.engine.flash
        if self.is_cut(erases=True):
            # Each bit is what it was, or 1 already.
            share = self.erased_part
            ones = [sum((self.chance.random() < share) << bit for bit in range(8)) for _ in range(size)]
            flash[begin : begin + size] = bytes(a | b for a, b in zip(flash[begin : begin + size], ones))
            return self.chip.cut_power_now()
        flash[begin : begin + size] = b"\xff" * size
        self.erased.append((self.chip.now(), number))
        self.chip.core.stall += ERASE_16K[min(value >> 8 & 3, 2)] * size // 0x4000 * (SLOWEST_ERASE if self.is_slow else 1)

    def program(self, address, size, value):
        """The core writes to the memory of the flash, which then takes the value."""
        flash, cr, offset = self.chip.engine.flash, self["CR"], address - BASE
        old = int.from_bytes(flash[offset : offset + size], "little")
        value &= (1 << 8 * size) - 1
        if not cr & PG or cr & LOCK:
            self.breach(f"{address:#x} is written without PG")
        elif 1 << (cr >> 8 & 3) != size:
            self.breach(f"{address:#x} is written with {size} bytes and PSIZE {cr >> 8 & 3}")
        elif address % size:
            self.breach(f"{address:#x} is not aligned to {size} bytes")
        elif not PARAMETERS <= address < PARAMETERS + PARAMETERS_SIZE:
            self.breach(f"{address:#x}, where no parameters are, is written")
        else:
            if old & value != value:
                self.breach(f"{address:#x}: {old:#x} -> {value:#x} sets bits")
            self.programmed += 1
            self.chip.core.stall += int(PROGRAM * (SLOWEST_PROGRAM if self.is_slow else 1))
            if self.is_cut():
                # Some of the bits are 0 by now.
                zeros = old & ~value & self.chance.getrandbits(8 * size)
                flash[offset : offset + size] = (old & ~zeros).to_bytes(size, "little")
                self.chip.cut_power_now()

    def is_cut(self, erases=False):
        """Whether the power goes away in the middle of this operation."""
        if self.operations_until_cut is not None:
            self.operations_until_cut -= 1
        if self.erases_until_cut is not None and erases:
            self.erases_until_cut -= 1
        return 0 in (self.operations_until_cut, self.erases_until_cut)
