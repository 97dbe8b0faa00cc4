"""The system control space (PM0214, 4): NVIC, SysTick, SCB, the FPU's way of stacking and the cycle counter, and the debug block."""

import collections

from .clock import NEVER
from .faults import Faults
from .registers import Peripheral, Register

#: Numbers of exceptions.
NMI, HARD_FAULT, SVCALL, PENDSV, SYSTICK_EXCEPTION = 2, 3, 11, 14, 15

BASE = 0xE000_0000
SYSTICK, NVIC, SCB = 0xE010, 0xE100, 0xED00

#: FPCCR: registers of the FPU are stacked of themselves, and only when they are needed; they have not been yet.
ASPEN, LSPEN, LSPACT = 1 << 31, 1 << 30, 1

#: ICSR: the bit that makes an exception pending, and the one that takes it back.
PENDING = {31: (NMI, True), 28: (PENDSV, True), 27: (PENDSV, False), 26: (SYSTICK_EXCEPTION, True), 25: (SYSTICK_EXCEPTION, False)}

#: SCR: sleep again behind the last handler; CCR behind a reset: frames of eight bytes; DEMCR: the cycle counter has its clock.
SLEEPONEXIT, STKALIGN, TRCENA = 2, 1 << 9, 1 << 24

CPUID = 0x410F_C241

#: Registers of the core that are storage here, with what they have after a reset: offset, name,
#: bits that may be written, value. The access to the FPU is unicorn's.
STORED = {
    0xED08: ("VTOR", 0x3FFF_FE00, 0),
    0xED88: ("CPACR", 0x00F0_0000, 0),
}

#: Where what faults tell lies, and the MPU.
FAULTS = (0xED24, 0xED28, 0xED2C, 0xED34, 0xED38)
MPU = range(0xED90, 0xEDBC, 4)


class System:
    def __init__(self, core):
        self.core, self.chip = core, core.chip
        self.stored = {offset: value for offset, (_, _, value) in STORED.items()}
        self.enabled, self.pending = set(), set()
        self.priority = collections.defaultdict(int, {NMI: -2, HARD_FAULT: -1})
        self.control, self.reload = 0, 0
        self.ticks_at = NEVER
        self.faults = Faults(self)
        self.is_lazy, self.float_at, self.sleeps_on_exit = True, 0, False
        #: When the cycle counter was 0, while it counts; else what it shows.
        self.traces, self.counts_from, self.cycles = False, None, 0

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
        if offset in self.stored:
            return self.stored[offset]
        if offset in FAULTS:
            return self.faults.load(offset)
        if offset in MPU:
            return self.faults.mpu.load(offset)
        reader = self.READERS.get(offset)
        if reader is not None:
            return reader(self)
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
        elif offset in FAULTS:
            self.faults.store(offset, value)
        elif offset in MPU:
            self.faults.mpu.store(offset, value)
        elif offset in self.WRITERS:
            self.WRITERS[offset](self, value)
        else:
            self.chip.breach(f"core register {BASE + offset:#x} written with {value:#x}, which is not modelled")

    def unmodelled(self, name, value):
        self.chip.breach(f"{name} written with {value:#x}: what that does is not modelled")

    def store_icsr(self, value):
        for bit, (number, is_set) in PENDING.items():
            if value >> bit & 1:
                self.core.pend(number) if is_set else self.pending.discard(number)

    def store_aircr(self, value):
        if value >> 16 != 0x05FA or value & 0xFFFF & ~4:
            return self.unmodelled("AIRCR", value)
        self.chip.reset_asked |= bool(value & 4)

    def store_scr(self, value):
        if value & ~SLEEPONEXIT:
            self.unmodelled("SCR", value)
        self.sleeps_on_exit = bool(value & SLEEPONEXIT)

    def store_ccr(self, value):
        if value != STKALIGN:
            self.unmodelled("CCR", value)

    def store_fpccr(self, value):
        if not value & ASPEN or value & ~(ASPEN | LSPEN | LSPACT):
            self.unmodelled("FPCCR", value)
        self.is_lazy = bool(value & LSPEN)

    def load_fpccr(self):
        return ASPEN | self.is_lazy * LSPEN | (self.core.lazy is not None) * LSPACT

    # The cycle counter.

    def store_demcr(self, value):
        if value & ~TRCENA:
            self.unmodelled("DEMCR", value)
        self.traces = bool(value & TRCENA)

    def store_dwt(self, value):
        if value & ~1 or not self.traces:
            self.unmodelled("DWT_CTRL", value)
        self.cycles = self.load_cycles()
        self.counts_from = self.chip.now() - self.cycles if value & 1 else None

    def load_cycles(self):
        if not self.traces:
            self.chip.breach("the cycle counter is looked at without TRCENA")
        return self.cycles if self.counts_from is None else self.chip.now() - self.counts_from & 0xFFFF_FFFF

    def store_cycles(self, value):
        self.cycles = value
        if self.counts_from is not None:
            self.counts_from = self.chip.now() - value

    READERS = {
        0xED00: lambda self: CPUID,
        0xED04: lambda self: self.core.active[-1][0] if self.core.active else 0,
        0xED0C: lambda self: 0xFA05_0000,
        0xED10: lambda self: self.sleeps_on_exit * SLEEPONEXIT,
        0xED14: lambda self: STKALIGN,
        0xEF34: load_fpccr,
        0xEF38: lambda self: self.float_at,
        0xEDFC: lambda self: self.traces * TRCENA,
        0x1000: lambda self: 0x4000_0000 | (self.counts_from is not None),
        0x1004: load_cycles,
    }
    WRITERS = {
        0xED04: store_icsr, 0xED0C: store_aircr, 0xED10: store_scr, 0xED14: store_ccr, 0xEF34: store_fpccr, 0xEDFC: store_demcr, 0x1000: store_dwt,
        0x1004: store_cycles,
    }  # fmt: skip

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
