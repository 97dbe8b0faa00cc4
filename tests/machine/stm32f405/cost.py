"""What the core's instructions cost: a model, where the rest of this machine counts one clock for each. `Core.count_cost` switches it on.

It knows flash with five wait states behind the accelerator (RM0090, 3.4: 64 lines of instructions and 8 of data, 16 bytes each, the least
recently used one makes way, the next line fetched ahead), what branches, loads, divisions, the FPU and exceptions take (Cortex-M4 TRM, 3.3 and
7.2.3, and PM0214, 2.3.7), and the way to a peripheral through its bridge. Instructions in RAM take turns with their constants, and with a stack
that is there too, a clock for each word; of other masters that want the same memory at once it knows nothing. No silicon has confirmed it. With it
on, the machine has a moment for each block of instructions, so that waits, masked interrupts and stacks are seen as they are.
"""

import collections

from unicorn import UC_HOOK_BLOCK, UC_HOOK_MEM_READ
from unicorn.arm_const import UC_ARM_REG_BASEPRI, UC_ARM_REG_PRIMASK, UC_ARM_REG_SP, UC_ARM_REG_XPSR

from .fpu import Fpu, is_float

#: Clocks of waiting for a line of flash at 168 MHz and 3.3 V.
WAIT_STATES = 5
LINE = 16
INSTRUCTION_LINES, DATA_LINES = 64, 8

#: To fill the pipeline behind a branch that is taken (1 to 3), and a division (2 to 12).
BRANCH, DIVISION = 2, 6
#: To stack a frame and fetch the vector, to come back, and from one exception to the next without
#: either.
ENTRY, EXIT, CHAINED = 12, 12, 6

#: Clocks more of an access by the bus it is on: two clocks of the bus and the wait for its edge, by the first address behind the bus.
BUSES = ((0x1_0000, 10), (0x2_0000, 5), (0x8_0000, 1))

FLASH, FLASH_END = 0x0800_0000, 0x0810_0000

#: RAM: at its own address it is fetched from by the system bus, which holds each word for a clock; mapped to 0, by the bus for instructions.
RAM = 0x2000_0000

#: In XPSR: the condition that an instruction is under, and those behind it (IT).
CONDITION = 0x0600_FC00

#: Registers by which a program reaches its stack, and its constants.
SP, PC = 13, 15


def access(offset):
    """What an access to a peripheral costs, by its offset from 4000_0000h."""
    return next((clocks for end, clocks in BUSES if offset < end), 1)


def is_wide(half):
    return half >> 11 >= 0b11101


def looks_at(half, second):
    """Whether an instruction may change what is masked, or the stack pointer."""
    if not is_wide(half):
        return half & 0xFFE8 == 0xB660 or half & 0xFF80 == 0xB080 or half >> 9 == 0b1011010
    return half & 0xFFF0 == 0xF380 and second >> 12 == 8 or half & 0xFFBF == 0xE92D & 0xFFBF or half & 0xFBEF == 0xF1AD


def extra(half, second):
    """Clocks beyond the first one."""
    if not is_wide(half):
        top = half >> 12
        if top == 0xB and half >> 9 & 3 == 2:
            # PUSH and POP.
            return (half & 0x1FF).bit_count()
        if top == 0xC:
            return (half & 0xFF).bit_count()
        # Loads; a store goes through a buffer.
        is_load = half >> 11 == 0b01001 or top == 5 and half & 0xE00 >= 0x600 or top in (6, 7, 8, 9) and half & 0x800
        return 1 if is_load else 0
    if half & 0xFE40 == 0xE800:
        return second.bit_count()
    if half & 0xFE40 == 0xE840:
        return 2
    if half & 0xFE10 == 0xF810:
        return 1
    if half & 0xFFD0 == 0xFB90 and second & 0xF0 == 0xF0:
        return DIVISION
    return 0


def words(half, second):
    """Words of the stack that an instruction has, and words of its constants."""
    if not is_wide(half):
        if half >> 12 == 0xB and half >> 9 & 3 == 2:
            return (half & 0x1FF).bit_count(), 0
        return int(half >> 12 == 9), int(half >> 11 == 0b01001)
    if is_float(half, second):
        count = 0 if half >> 8 == 0xEE else 1 + (second >> 8 & 1) if half & 0x120 == 0x100 else second & 0xFF
    elif half & 0xFE40 == 0xE800:
        count = second.bit_count()
    else:
        count = 2 if half & 0xFE40 == 0xE840 else int(half & 0xFE00 == 0xF800)
    return count if half & 0xF == SP else 0, count if half & 0xF == PC else 0


class Lines:
    """A cache of lines of flash; the least recently used one makes way."""

    def __init__(self, number):
        self.number, self.lines = number, collections.OrderedDict()

    def holds(self, line):
        if line in self.lines:
            self.lines.move_to_end(line)
            return True
        self.lines[line] = None
        if len(self.lines) > self.number:
            self.lines.popitem(last=False)
        return False


class Cost:
    """Counts along with a core."""

    def __init__(self, core):
        self.core, self.uc = core, core.uc
        self.blocks = {}
        self.instructions, self.data = Lines(INSTRUCTION_LINES), Lines(DATA_LINES)
        #: The address behind the block that runs, and what this slice has cost beyond its instructions, and how many of these it has begun.
        self.next, self.extra, self.begun = 0, 0, 0
        self.look = False
        #: Clocks beyond the first one of each instruction of this block.
        self.extras = ()
        #: Since when what is masked: by PRIMASK, and by BASEPRI up to a level.
        self.masked = {}
        self.longest = collections.Counter()
        #: The lowest stack pointer of what runs at each depth of nesting, and the deepest stack of each priority.
        self.depth = collections.Counter()
        #: When each handler that runs began, and the longest that each exception has taken, with all that came in between.
        self.entered, self.runs = [], collections.Counter()
        core.uc.hook_add(UC_HOOK_BLOCK, self.on_block)
        core.uc.hook_add(UC_HOOK_MEM_READ, self.on_read, None, FLASH, FLASH_END - 1)

    def forget(self):
        """What was measured so far."""
        self.longest.clear()
        self.depth.clear()
        self.runs.clear()
        self.masked = {}

    def enter(self):
        """A handler begins."""
        self.note_stack()
        self.entered.append(self.core.chip.time)

    def leave(self, number):
        """It has ended. Those that had begun before there was a model of cost are not counted."""
        if self.entered:
            self.runs[number] = max(self.runs[number], self.now() + self.core.stall - self.entered.pop())

    def now(self):
        """The moment in the slice, to a block."""
        return self.core.chip.time + self.begun + self.extra

    def cut(self, count, at):
        """The slice has ended at an address in the middle of a block; so many of its instructions are for the next one."""
        self.extra -= sum(self.extras[-count:])
        self.next = at

    def take(self):
        """What the slice has cost beyond its instructions; a new one begins."""
        extra, self.extra, self.begun = self.extra, 0, 0
        return extra

    def decode(self, address, size):
        code = bytes(self.uc.mem_read(address, size + 2))
        extras, look, i, fpu = [], False, 0, Fpu()
        while i < size:
            half = int.from_bytes(code[i : i + 2], "little")
            second = int.from_bytes(code[i + 2 : i + 4], "little")
            if is_float(half, second):
                extras.append(fpu.extra(half, second))
            else:
                extras.append(extra(half, second))
                fpu.pass_by(1 + extras[-1])
            if address < FLASH and self.core.engine.has_low_ram:
                of_stack, constants = words(half, second)
                extras[-1] += constants + (of_stack if self.core.top > RAM else 0)
            elif address >= RAM:
                extras[-1] += 1
            look |= looks_at(half, second)
            i += 4 if is_wide(half) else 2
        extras[-1] += fpu.rest()
        lines = range(address // LINE, (address + size - 1) // LINE + 1) if FLASH <= address < FLASH_END else ()
        return extras, look, lines

    def on_block(self, _uc, address, size, _):
        if self.look:
            self.look_around()
        known = self.blocks.get((address, size))
        if known is None:
            known = self.blocks[address, size] = self.decode(address, size)
        self.extras, self.look, lines = known
        clocks = sum(self.extras)
        goes_on = address == self.next
        if not goes_on:
            clocks += BRANCH
        for line in lines:
            if not self.instructions.holds(line):
                # Behind another line this one is on its way while that is executed.
                clocks += 1 if goes_on else WAIT_STATES
            goes_on = True
        self.next = address + size
        self.extra += clocks
        self.begun += len(self.extras)

    def on_read(self, uc, _access, address, _size, _value, _):
        if not self.data.holds(address // LINE):
            self.extra += WAIT_STATES
        # For this hook unicorn notes the condition that it is under, and takes all that is behind the next branch to be under it, too.
        xpsr = uc.reg_read(UC_ARM_REG_XPSR)
        if xpsr & CONDITION:
            uc.reg_write(UC_ARM_REG_XPSR, xpsr & ~CONDITION)

    def priority(self):
        return self.core.active[-1][1] if self.core.active else 256

    def look_around(self):
        """Behind an instruction that may have changed what is masked, or the stack."""
        uc, now, priority = self.uc, self.now(), self.priority()
        self.note("all", uc.reg_read(UC_ARM_REG_PRIMASK) & 1, now)
        base = uc.reg_read(UC_ARM_REG_BASEPRI) & 0xF0
        for level in range(0x10, min(priority, 0x100), 0x10):
            # What is no more urgent than who runs waits for its end anyway.
            self.note(level, base and base <= level, now)
        self.note_stack()

    def note(self, what, is_masked, now):
        if is_masked:
            self.masked.setdefault(what, now)
        elif what in self.masked:
            self.longest[what] = max(self.longest[what], now - self.masked.pop(what))

    def note_stack(self):
        core = self.core
        base = core.bases[-1] if core.bases else core.top
        self.depth[self.priority()] = max(self.depth[self.priority()], base - self.uc.reg_read(UC_ARM_REG_SP))


class Shares:
    """How much of the time each priority has had: clocks by priority, 256 for what runs outside of exceptions, None for sleep."""

    def __init__(self):
        self.clocks = collections.Counter()

    def add(self, priority, clocks):
        self.clocks[priority] += clocks

    def of(self, priority):
        whole = sum(self.clocks.values())
        return self.clocks[priority] / whole if whole else 0
