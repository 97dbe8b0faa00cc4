"""The system control space (PM0214, 4): NVIC, SysTick and SCB, and the debug block."""

import collections

from .clock import NEVER
from .registers import Peripheral, Register

BASE = 0xE000_0000
SYSTICK, NVIC, SCB = 0xE010, 0xE100, 0xED00

#: Registers of the core that are storage here, with what they have after a reset: offset, name,
#: bits that may be written, value. The access to the FPU is unicorn's.
STORED = {
    0xED08: ("VTOR", 0x3FFF_FE00, 0),
    0xED88: ("CPACR", 0x00F0_0000, 0),
}

#: Numbers of exceptions.
NMI, HARD_FAULT, SVCALL, SYSTICK_EXCEPTION = 2, 3, 11, 15


class System:
    def __init__(self, core):
        self.core, self.chip = core, core.chip
        self.stored = {offset: value for offset, (_, _, value) in STORED.items()}
        self.enabled, self.pending = set(), set()
        self.priority = collections.defaultdict(int, {NMI: -2, HARD_FAULT: -1})
        self.control, self.reload = 0, 0
        self.ticks_at = NEVER

    def name(self, offset):
        return STORED[offset][0] if offset in STORED else f"core register {BASE + offset:#x}"

    # The bus.

    def check_width(self, offset, size):
        """Priorities alone are bytes."""
        if size != 4 and not (0xE400 <= offset < 0xE4F0 or 0xED18 <= offset < 0xED24):
            self.chip.breach(f"{self.name(offset)} accessed with {size} bytes")

    def load(self, offset, size):
        self.check_width(offset, size)
        if offset == 0xE010:
            return self.control
        if offset == 0xE014:
            return self.reload
        if offset == 0xE018:
            return max(0, self.ticks_at - self.chip.now()) & 0xFF_FFFF if self.ticks_at != NEVER else 0
        if 0xE100 <= offset < 0xE300:
            word, kind = offset % 0x80 // 4, offset - 0xE100 >> 7
            group = (n in self.enabled for n in range(32 * word, 32 * word + 32)) if kind < 2 else (
                n + 16 in self.pending for n in range(32 * word, 32 * word + 32)
            )
            return sum(bit << i for i, bit in enumerate(group))
        if 0xE400 <= offset < 0xE4F0:
            return sum(self.priority[16 + offset - 0xE400 + i] << 8 * i for i in range(size))
        if 0xED18 <= offset < 0xED24:
            return sum(self.priority[4 + offset - 0xED18 + i] << 8 * i for i in range(size))
        if offset == 0xED04:
            return self.core.active[-1][0] if self.core.active else 0
        if offset in self.stored:
            return self.stored[offset]
        self.chip.breach(f"core register {BASE + offset:#x} read, which is not modelled")
        return 0

    def store(self, offset, size, value):
        self.check_width(offset, size)
        if offset == 0xE010:
            if value & 1 and not self.control & 1:
                self.ticks_at = self.chip.now() + self.reload + 1
            elif not value & 1:
                self.ticks_at = NEVER
            self.control = value & 7
        elif offset == 0xE014:
            if value >> 24:
                self.chip.breach(f"SysTick: a reload of {value:#x} has more than 24 bits")
            self.reload = value
        elif offset == 0xE018:
            pass
        elif 0xE100 <= offset < 0xE300:
            self.store_nvic(offset, value)
        elif 0xE400 <= offset < 0xE4F0:
            self.store_priorities(16 + offset - 0xE400, size, value)
        elif 0xED18 <= offset < 0xED24:
            self.store_priorities(4 + offset - 0xED18, size, value)
        elif offset in self.stored:
            name, bits, _ = STORED[offset]
            if (value ^ self.stored[offset]) & ~bits:
                self.chip.breach(f"{name} written with {value:#x}: bits outside of {bits:#x} changed")
            self.stored[offset] = value
        else:
            self.chip.breach(f"core register {BASE + offset:#x} written with {value:#x}, which is not modelled")

    def store_nvic(self, offset, value):
        word, kind = offset % 0x80 // 4, offset - 0xE100 >> 7
        for i in range(32):
            if value >> i & 1:
                n = 32 * word + i
                if kind == 0:
                    self.enabled.add(n)
                elif kind == 1:
                    self.enabled.discard(n)
                elif kind == 2:
                    self.pending.add(n + 16)
                else:
                    self.pending.discard(n + 16)

    def store_priorities(self, first, size, value):
        for i in range(size):
            byte = value >> 8 * i & 0xFF
            if byte & 0xF:
                self.chip.breach(f"priority {byte:#x} of exception {first + i}: the chip has the upper four bits")
            self.priority[first + i] = byte & 0xF0

    # SysTick.

    def tick(self, time):
        """The timer has come to 0; its reload register is taken now."""
        if self.control & 2:
            self.core.pend(SYSTICK_EXCEPTION)
        self.ticks_at += self.reload + 1
        if self.ticks_at < time:
            self.ticks_at = time + self.reload + 1


class Debug(Peripheral):
    """DBGMCU (RM0090, 38): what stops while a debugger holds the core."""

    NAME = "DBGMCU"
    REGISTERS = {
        0x08: Register("APB1_FZ", 0x0020_1C00 | 0x0600_0000 | 0x1FF | 1 << 12 | 1 << 11),
        0x0C: Register("APB2_FZ", 0x7_0003),
    }
