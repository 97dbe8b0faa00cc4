"""The core: instructions by unicorn, exceptions as the Cortex-M4F takes them (PM0214, 2.3). The stack is that of the main program; there
is no other."""

import collections
import copy
import struct

from unicorn import UcError
from unicorn.arm_const import (
    UC_ARM_REG_BASEPRI, UC_ARM_REG_CONTROL, UC_ARM_REG_D0, UC_ARM_REG_FPSCR, UC_ARM_REG_LR, UC_ARM_REG_PC,
    UC_ARM_REG_PRIMASK, UC_ARM_REG_R0, UC_ARM_REG_R1, UC_ARM_REG_R2, UC_ARM_REG_R3, UC_ARM_REG_R12, UC_ARM_REG_SP,
    UC_ARM_REG_XPSR,
)

from .cost import CHAINED, ENTRY, EXIT, Cost, Shares
from .engine import FLASH, FLASH_SIZE
from .faults import MSTKERR, STKERR
from .fpu import STACKED as FLOATS_STACKED
from .system import HARD_FAULT, NMI, SVCALL, System

#: Instructions that run without a look at the rest of the chip; more where interrupts have been
#: masked and nothing was touched all the while, as in most of a start.
SLICE, MASKED = 400, 6_400

#: What LR has in a handler: back to where the main stack was used, without and with registers of the FPU in the frame.
EXC_RETURN, EXC_RETURN_FP = 0xFFFF_FFF9, 0xFFFF_FFE9
RETURNS = (EXC_RETURN & ~1, EXC_RETURN_FP & ~1)

#: An interrupt whose line never falls meanwhile is one that nobody clears.
MOST_IN_A_ROW = 500

#: CONTROL: the FPU has been used.
FPCA = 4

#: Numbers of unicorn's interrupt hook: a branch to EXC_RETURN, and an SVC.
LEFT, CALLED = 8, 2

#: Instructions of a loop that is seen to be one.
LONGEST_LOOP = 8

WFI = b"\x30\xbf"

STACKED = (
    UC_ARM_REG_R0, UC_ARM_REG_R1, UC_ARM_REG_R2, UC_ARM_REG_R3, UC_ARM_REG_R12, UC_ARM_REG_LR,
)

FLOATS = [*(UC_ARM_REG_D0 + i for i in range(8)), UC_ARM_REG_FPSCR]

GENERAL = [*range(UC_ARM_REG_R0, UC_ARM_REG_R12 + 1), UC_ARM_REG_LR, UC_ARM_REG_XPSR, UC_ARM_REG_SP]


class Views:
    """The registers that are looked at together, of the engine at hand."""

    def __init__(self, engine):
        self.general = engine.registers(GENERAL)
        self.place = engine.registers((UC_ARM_REG_SP, UC_ARM_REG_PC))
        #: What masks exceptions.
        self.masks = engine.registers((UC_ARM_REG_PRIMASK, UC_ARM_REG_BASEPRI))
        #: What an entry reads, and what it leaves.
        self.entered = engine.registers((*STACKED, UC_ARM_REG_SP, UC_ARM_REG_XPSR, UC_ARM_REG_CONTROL))
        self.handler = engine.registers((UC_ARM_REG_SP, UC_ARM_REG_LR, UC_ARM_REG_XPSR, UC_ARM_REG_CONTROL))
        self.stack = engine.registers((UC_ARM_REG_SP, UC_ARM_REG_CONTROL))
        self.floats = engine.registers(FLOATS)


class Core:
    """One life of the core, from a reset to the next."""

    def __init__(self, chip):
        self.chip = chip
        self.attach()
        self.system = System(self)
        #: Clocks in which the core stands still (flash), accesses in this slice, whether one is under way.
        self.stall, self.accesses, self.slice = 0, 0, 0
        #: Instructions of the next slice at most, and whether PRIMASK held an exception back behind
        #: the last one.
        self.room, self.is_held = SLICE, False
        self.sleeping = self.loops = self.is_stopped = False
        #: Registers at places of what may be a loop, memory at one of them, and accesses to what
        #: changes of itself, or that change something.
        self.seen, self.whole, self.unsteady = {}, None, 0
        self.left, self.fault = False, None
        #: A handler has ended, and nothing has run since: what its way back has cost.
        self.way_back = 0
        #: Exceptions that are served: number, priority, and what their entry has stacked.
        self.active = []
        self.counts = collections.Counter()
        #: How often each interrupt has been asked for since its line last fell.
        self.again = {}
        #: When each exception became pending, and the longest that one has waited for its handler.
        self.pending_since, self.latency = {}, collections.Counter()
        self.instructions = 0
        self.pc = 0
        #: Where the stack of each exception that is served begins, and that of the rest.
        self.bases, self.top = [], 0
        #: Registers of the FPU of who was there before, and where in a frame their room is, as long as no handler has needed it: the core
        #: stacks them with the first instruction of one that uses the FPU (PM0214, 2.3.7).
        self.lazy = None
        #: The model of cost, if there is one, and how many clocks each priority has had.
        self.cost, self.shares = None, Shares()

    def attach(self):
        """The engine of the chip is the one that it runs on."""
        self.engine = engine = self.chip.engine
        self.uc, self.views = engine.uc, Views(engine)
        if hasattr(self, "system"):
            self.system.faults.mpu.apply()

    def __deepcopy__(self, memo):
        twin = memo[id(self)] = Core.__new__(Core)
        of_engine = ("uc", "views", "engine")
        twin.__dict__ = {name: copy.deepcopy(value, memo) for name, value in self.__dict__.items() if name not in of_engine}
        return twin

    def count_cost(self):
        """From now on an instruction takes what the model of cost says."""
        self.cost = Cost(self)
        # What has been translated knows nothing of it.
        self.uc.ctl_flush_tb()
        return self.cost

    def start(self):
        """Comes out of reset."""
        sp, pc = struct.unpack_from("<II", self.engine.flash)
        self.engine.clear()
        self.uc.reg_write(UC_ARM_REG_SP, sp)
        self.pc, self.lowest_stack, self.top = pc | 1, sp, sp

    def load(self, offset, size):
        """The core's own registers, and the debugger's."""
        self.accesses += 1
        self.unsteady += 1
        if 0x42000 <= offset < 0x42400:
            return self.chip.debug.load(offset - 0x42000, size)
        return self.system.load(offset, size)

    def store(self, offset, size, value):
        self.accesses += 1
        self.chip.stale = True
        self.unsteady += 1
        if 0x42000 <= offset < 0x42400:
            self.chip.debug.store(offset - 0x42000, size, value)
        else:
            self.system.store(offset, size, value)

    def on_interrupt(self, number):
        if number == LEFT:
            self.left = True
        else:
            self.fault = number
        self.uc.emu_stop()

    def refuse(self, address):
        """There is nothing at an address, or the MPU forbids it."""
        self.system.faults.refused = address
        return False

    # Exceptions.

    def take_lines(self):
        """A level makes its interrupt pending, but while it is served."""
        standing = [16 + irq for peripheral in self.chip.with_lines for irq in peripheral.lines()]
        served = [number for number, _, _ in self.active]
        if self.again:
            self.again = {number: times for number, times in self.again.items() if number in standing}
        for number in standing:
            if number not in served and number not in self.system.pending:
                self.pend(number)
                if number - 16 in self.system.enabled:
                    times = self.again[number] = self.again.get(number, 0) + 1
                    if times > MOST_IN_A_ROW:
                        self.chip.breach(f"interrupt {number - 16} is never cleared: served {MOST_IN_A_ROW} times while its line stood")
        if self.chip.rcc.nmi and NMI not in served:
            self.pend(NMI)

    def pend(self, number):
        """An exception waits from now on."""
        if number not in self.system.pending:
            self.system.pending.add(number)
            self.pending_since[number] = self.chip.time

    def current_priority(self, is_masked, base):
        """What an exception must be below of, in number, to come now: by what is served, PRIMASK
        and BASEPRI."""
        level = min([priority for _, priority, _ in self.active], default=256)
        if base & 0xF0:
            level = min(level, base & 0xF0)
        return min(level, 0) if is_masked & 1 else level

    def deliver(self):
        """Takes the most urgent exception, if it is more urgent than what runs."""
        system = self.system
        ready = [n for n in system.pending if n < 16 or n - 16 in system.enabled]
        if not ready:
            return
        number = min(ready, key=lambda n: (system.priority[n], n))
        self.sleeping = False
        is_masked, base = self.views.masks.read()
        if system.priority[number] < self.current_priority(is_masked, base):
            system.pending.discard(number)
            self.enter(number)
            is_masked = 0
        elif not is_masked or not self.is_held:
            # Soon it may come.
            self.room = SLICE
        self.is_held = is_masked

    def enter(self, number):
        engine, views = self.engine, self.views
        self.loops, self.seen, self.whole = False, {}, None
        *registers, sp, xpsr, control = views.entered.read()
        with_floats = bool(control & FPCA)
        size = 0x68 if with_floats else 0x20
        padded = bool(sp & 4)
        new = sp - size & ~7
        place = engine.place(new, size)
        if place is None or self.system.faults.mpu.refuses(new, size):
            # Nothing is stacked, and a hard fault comes in place of this.
            self.system.faults.status |= STKERR if place is None else MSTKERR
            number = HARD_FAULT
        else:
            struct.pack_into("<8I", *place, *registers, self.pc & ~1, xpsr & ~0x3FF | padded << 9 | 1 << 24)
            if with_floats:
                # A handler that has been there before and used the FPU is who was there.
                self.stack_floats(control)
                self.lazy = new + 0x20, views.floats.read()
                self.system.float_at = new + 0x20
                if not self.system.is_lazy:
                    self.stack_floats(control)
        if self.cost is not None:
            self.cost.enter()
            self.spend(CHAINED - self.way_back if self.way_back else ENTRY, self.system.priority[number])
        self.bases.append(sp)
        self.active.append((number, self.system.priority[number], (size, padded, with_floats, xpsr)))
        if self.system.priority[number] < 0:
            self.system.faults.mpu.apply()
        self.lowest_stack = min(self.lowest_stack, new)
        views.handler.write((new, EXC_RETURN_FP if with_floats else EXC_RETURN, 1 << 24 | number, control & ~FPCA if with_floats else control))
        vector = self.vector(number)
        if not vector & 1:
            self.chip.breach(f"exception {number} has no handler")
        self.pc = vector | 1
        self.counts[number] += 1
        waited = self.chip.time - self.pending_since.pop(number, self.chip.time)
        self.latency[number] = max(self.latency[number], waited)

    def stack_floats(self, control):
        """What was to be stacked is, as soon as the FPU has been used again; `control` tells whether it was."""
        if self.lazy is not None and control & FPCA:
            address, floats = self.lazy
            self.lazy = None
            place = self.engine.place(address, 0x48)
            if place is not None:
                struct.pack_into("<8QII", *place, *floats, 0)
                if self.cost is not None:
                    self.spend(FLOATS_STACKED, self.cost.priority())

    def spend(self, clocks, priority):
        """The core itself takes these, for this priority."""
        self.stall += clocks
        self.shares.add(priority, clocks)

    def vector(self, number):
        """Where the handler of an exception begins; at address 0 lies the flash."""
        at = (self.system.stored[0xED08] or FLASH) + 4 * number
        if FLASH <= at < FLASH + FLASH_SIZE:
            return struct.unpack_from("<I", self.engine.flash, at - FLASH)[0]
        return struct.unpack("<I", self.uc.mem_read(at, 4))[0]

    def leave(self):
        views = self.views
        sp, control = views.stack.read()
        self.stack_floats(control)
        number, priority, (size, padded, with_floats, xpsr) = self.active.pop()
        self.bases.pop()
        if priority < 0:
            self.system.faults.mpu.apply()
        self.chip.stale = True
        if self.cost is not None:
            # Those that were stacked come back.
            self.way_back = EXIT + (FLOATS_STACKED if with_floats and self.lazy is None else 0)
            self.spend(self.way_back, priority)
            self.cost.leave(number)
        memory, offset = self.engine.place(sp, size) or (self.uc.mem_read(sp, size), 0)
        *registers, pc, _ = struct.unpack_from("<8I", memory, offset)
        if with_floats and self.lazy is None:
            # It was needed meanwhile. Otherwise all is where it was.
            views.floats.write(struct.unpack_from("<8QI", memory, offset + 0x20))
        if with_floats:
            self.lazy = None
        control = control | FPCA if with_floats else control & ~FPCA
        views.entered.write((*registers, sp + size | padded << 2, xpsr | 1 << 24, control))
        self.pc = pc | 1
        self.sleeping = not self.active and self.system.sleeps_on_exit

    def hard_fault(self):
        if self.active and self.active[-1][1] <= -1:
            # A fault in the handler of faults: the core locks up.
            self.is_stopped = True
            self.chip.locked_up = True
            return
        self.enter(HARD_FAULT)

    # Running.

    def run_slice(self, most):
        """Runs so many instructions at most, 1 or more. Gives the clocks that they took."""
        uc = self.uc
        count = max(1, min(most, self.room) if self.cost is None else min(most // 2, SLICE // 4))
        priority = self.active[-1][1] if self.active else 256
        clocks = self.run_instructions(count)
        if self.cost is not None:
            clocks += self.cost.take()
        self.shares.add(priority, clocks)
        return clocks

    def run_instructions(self, count):
        uc = self.uc
        self.accesses, self.unsteady, self.slice, self.way_back = 0, 0, count, 0
        self.loops = False
        try:
            uc.emu_start(self.pc, RETURNS[0], 0, count)
        except UcError as error:
            # No memory there, or the MPU forbids it, or no such instruction.
            self.pc, self.slice = uc.reg_read(UC_ARM_REG_PC) | 1, 0
            self.system.faults.of_access(error)
            return count
        self.slice = 0
        self.room = min(2 * self.room, MASKED) if self.is_held and not self.accesses else SLICE
        sp, pc = self.views.place.read()
        if self.fault is not None:
            number, self.fault = self.fault, None
            self.pc = pc | 1
            self.enter(SVCALL) if number == CALLED else self.system.faults.of_instruction(number)
        elif self.left or pc in RETURNS:
            self.left = False
            self.leave()
            # unicorn does not tell where in the slice it was.
            count = min(count, 8 * self.accesses + 40 if self.cost is None else self.cost.begun)
        else:
            self.idles(pc)
            self.pc = pc | 1
            if self.cost is not None and self.cost.begun > count:
                self.cost.cut(self.cost.begun - count, pc)
            at = pc - 2 - FLASH
            if self.engine.flash[at : at + 2] == WFI:
                self.sleeping = True
                count = min(count, 20 if self.cost is None else self.cost.begun)
        if self.lazy is not None:
            self.stack_floats(self.views.stack.read()[1])
        if sp < self.lowest_stack:
            self.lowest_stack = sp
        self.instructions += count
        return count

    def idles(self, pc):
        """An endless loop: it has come to the same place with the same registers and the same
        memory, and looked at nothing but what only an event changes. It goes on until one, or an
        exception."""
        if self.unsteady:
            self.seen, self.whole = {}, None
            return
        if pc not in self.seen and len(self.seen) > LONGEST_LOOP:
            self.seen, self.whole = {}, None
        state = self.views.general.read()
        if state == self.seen.get(pc) and (self.whole is None or pc == self.whole[0]):
            # Memory is compared from the second time on, as most loops count in it.
            whole = pc, self.engine.everything()
            self.loops = whole == self.whole
            self.whole = whole
        self.seen[pc] = state

    def since_slice(self):
        """Clocks since the slice began."""
        if self.cost is not None and self.slice:
            return self.cost.now() - self.chip.time + self.stall
        return (min(8 * self.accesses, self.slice) if self.slice else 0) + self.stall
