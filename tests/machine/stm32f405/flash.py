"""The flash controller (RM0090, 3): keys, erasing, programming. While it works, the core stands still: its code lies in the same flash."""

from .clock import HZ, MS, US
from .engine import FLASH as BASE
from .registers import Peripheral, Register

KEYS = [0x4567_0123, 0xCDEF_89AB]
LOCK, STRT, PG, SER, MER = 1 << 31, 1 << 16, 1, 2, 4
ERRORS = 0xF2

#: Begin and size of each sector.
SECTORS = [(i * 0x4000, 0x4000) for i in range(4)] + [(0x10000, 0x10000)] + [(0x20000 * i, 0x20000) for i in range(1, 8)]

#: Typical times (data sheet, 5.3.12): programming by size in bytes, and erasing 16 KiB by PSIZE; larger sectors in proportion.
PROGRAM = {1: 16 * US, 2: 16 * US, 4: 16 * US, 8: 16 * US}
ERASE_16K = {0: 400 * MS, 1: 300 * MS, 2: 250 * MS}


class Flash(Peripheral):
    NAME = "FLASH"
    WRITE_SIZES = (1, 2, 4)
    REGISTERS = {
        0x00: Register("ACR", 0x1F07, 0, keep=False),
        0x04: Register("KEYR"),
        0x08: Register("OPTKEYR"),
        0x0C: Register("SR", 0, rc_w1=ERRORS | 1, keep=False),
        0x10: Register("CR", 0x8101_037F | 1 << 24, LOCK),
        0x14: Register("OPTCR", 0x0FFF_FFEF, 0x0FFF_AAED),
    }

    def __init__(self, chip):
        self.keys, self.option_keys = [], []
        self.erased, self.programmed = [], 0
        self.programs_until_cut = None
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

    def write_OPTKEYR(self, value):
        self.option_keys.append(value)
        if self.option_keys[-2:] == [0x0819_2A3B, 0x4C5D_6E7F]:
            self["OPTCR"] &= ~1

    def write_OPTCR(self, value):
        if self["OPTCR"] & 1:
            return self.breach("OPTCR written while locked")
        if value & 2:
            # Kept over a reset; it takes some hundred milliseconds (the sector of the options).
            self.chip.option_bytes = value & ~3
            self.chip.core.stall += ERASE_16K[2]
        self["OPTCR"] = value & ~2

    def reset(self):
        super().reset()
        self["OPTCR"] = getattr(self.chip, "option_bytes", 0x0FFF_AAEC) | 1
        self.keys, self.option_keys = [], []

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
        self.chip.engine.flash[begin : begin + size] = b"\xff" * size
        self.erased.append((self.chip.now(), number))
        self.chip.core.stall += ERASE_16K[min(value >> 8 & 3, 2)] * size // 0x4000
        self.cut_after_this()

    def on_store(self, _uc, _access, address, size, value, _):
        """The core writes to the memory of the flash."""
        cr, offset = self["CR"], address - BASE
        old = int.from_bytes(self.chip.engine.flash[offset : offset + size], "little")
        value &= (1 << 8 * size) - 1
        if not cr & PG or cr & LOCK:
            return self.breach(f"{address:#x} is written without PG")
        if 1 << (cr >> 8 & 3) != size:
            return self.breach(f"{address:#x} is written with {size} bytes and PSIZE {cr >> 8 & 3}")
        if address % size:
            return self.breach(f"{address:#x} is not aligned to {size} bytes")
        if old & value != value:
            self.breach(f"{address:#x}: {old:#x} -> {value:#x} sets bits")
        self.programmed += 1
        self.chip.core.stall += PROGRAM[size]
        self.cut_after_this()

    def cut_after_this(self):
        if self.programs_until_cut is not None:
            self.programs_until_cut -= 1
            if self.programs_until_cut == 0:
                # The operation is done, and what follows never happens.
                self.programs_until_cut = None
                self.chip.cut_power_now()
