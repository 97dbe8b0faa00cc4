"""unicorn, and the memory it runs in. What it has once translated of an image is kept: a chip that
is done with leaves its engine to the next."""

import collections
import ctypes
import struct

from unicorn import UC_ARCH_ARM, UC_HOOK_INTR, UC_HOOK_MEM_INVALID, UC_HOOK_MEM_WRITE, UC_MODE_MCLASS, UC_MODE_THUMB, UC_PROT_ALL, UC_PROT_EXEC, UC_PROT_READ, Uc
from unicorn.arm_const import (
    UC_ARM_REG_BASEPRI, UC_ARM_REG_CONTROL, UC_ARM_REG_D0, UC_ARM_REG_FPSCR, UC_ARM_REG_LR, UC_ARM_REG_PRIMASK,
    UC_ARM_REG_R0, UC_ARM_REG_R12, UC_ARM_REG_SP, UC_ARM_REG_XPSR, UC_CPU_ARM_CORTEX_M4,
)

# Python's way to a register makes several objects; a look at the core takes place tens of thousands
# of times a second.
from unicorn.unicorn_py3.unicorn import uclib

RAM, RAM_SIZE = 0x2000_0000, 0x2_0000
CCM, CCM_SIZE = 0x1000_0000, 0x1_0000
FLASH, FLASH_SIZE = 0x0800_0000, 0x10_0000
SYSTEM_MEMORY, SYSTEM_MEMORY_SIZE = 0x1FFF_7000, 0x1000

#: A serial number, 1 MiB of flash, and what the temperature sensor reads at 30 °C and 110 °C.
UNIQUE_ID = bytes.fromhex("2a003b000d51353238333733")
CALIBRATION = struct.pack("<HH", 943, 1194)

#: How much of each memory is at 0 too, where it is mapped there (RM0090, 2.4): of RAM the first block.
LOW_RAM_SIZE = 0x1_C000

#: Where the parameters are stored.
PARAMETERS, PARAMETERS_SIZE = 0x0800_8000, 0x8000

#: Where each bit of the RAM is a word.
BITS_OF_RAM = 0x2200_0000

#: Parts of the chip that are not modelled and lie outside of what the peripherals' buses have: bits of
#: RAM that this chip has not, AHB2, the external memories and their controller.
ELSEWHERE = ((BITS_OF_RAM + 32 * RAM_SIZE, 0x200_0000 - 32 * RAM_SIZE), (0x5000_0000, 0x6_1000), (0x6000_0000, 0x4000_0000), (0xA000_0000, 0x1000))

#: What access rights are for.
PAGE = 0x400

#: The memories of which the core may be refused parts.
MEMORIES = ((FLASH, FLASH_SIZE), (CCM, CCM_SIZE), (RAM, RAM_SIZE))

#: Everything that a program can have in the core; there is one stack.
STATE = [
    *range(UC_ARM_REG_R0, UC_ARM_REG_R12 + 1), UC_ARM_REG_SP, UC_ARM_REG_LR, UC_ARM_REG_XPSR, UC_ARM_REG_PRIMASK, UC_ARM_REG_BASEPRI,
    UC_ARM_REG_CONTROL, *range(UC_ARM_REG_D0, UC_ARM_REG_D0 + 16), UC_ARM_REG_FPSCR,
]  # fmt: skip


class Registers:
    """Some registers of a core, read or written at once."""

    def __init__(self, uc, numbers):
        count = len(numbers)
        self.handle = uc._uch
        self.values = (ctypes.c_uint64 * count)()
        first = ctypes.addressof(self.values)
        self.arguments = (ctypes.c_int32 * count)(*numbers), (ctypes.c_void_p * count)(*(first + 8 * i for i in range(count))), count

    def read(self):
        uclib.uc_reg_read_batch(self.handle, *self.arguments)
        return self.values[:]

    def write(self, values):
        self.values[:] = values
        uclib.uc_reg_write_batch(self.handle, *self.arguments)


class Engine:
    """One core of unicorn with one image in its flash. `chip` is who uses it."""

    #: Engines without a chip, by image.
    free = collections.defaultdict(list)

    def __init__(self, image):
        self.image, self.chip, self.is_restricted = image, None, False
        self.uc = uc = Uc(UC_ARCH_ARM, UC_MODE_THUMB | UC_MODE_MCLASS)
        uc.ctl_set_cpu_model(UC_CPU_ARM_CORTEX_M4)
        self.flash, self.ccm, self.ram = self.map(FLASH, FLASH_SIZE), self.map(CCM, CCM_SIZE), self.map(RAM, RAM_SIZE)
        self.flash[:] = b"\xff" * FLASH_SIZE
        for address, data in image.segments:
            self.flash[address - FLASH : address - FLASH + len(data)] = data
        self.system = self.map(SYSTEM_MEMORY, SYSTEM_MEMORY_SIZE)
        for offset, data in ((0xA10, UNIQUE_ID), (0xA22, struct.pack("<H", 1024)), (0xA2C, CALIBRATION)):
            self.system[offset : offset + len(data)] = data
        self.state = self.registers(STATE)
        #: Whether the RAM is at 0, and not the flash, from which the core starts.
        self.has_low_ram = None
        self.map_low(False)
        self.connect()

    def map(self, address, size):
        """Memory that this side sees as it is."""
        memory = (ctypes.c_uint8 * size)()
        self.uc.mem_map_ptr(address, size, UC_PROT_ALL, ctypes.addressof(memory))
        return memoryview(memory).cast("B")

    def map_low(self, ram):
        """What is at 0 as well: the RAM, or the flash, which nobody programs there."""
        if ram == self.has_low_ram:
            return
        if self.has_low_ram is not None:
            self.uc.mem_unmap(0, LOW_RAM_SIZE if self.has_low_ram else FLASH_SIZE)
        memory, size, rights = (self.ram, LOW_RAM_SIZE, UC_PROT_ALL) if ram else (self.flash, FLASH_SIZE, UC_PROT_READ | UC_PROT_EXEC)
        self.uc.mem_map_ptr(0, size, rights, ctypes.addressof(ctypes.c_uint8.from_buffer(memory)))
        self.has_low_ram = ram

    def connect(self):
        """The buses."""
        uc = self.uc
        uc.mmio_map(
            0x4000_0000, 0x80000,
            lambda _uc, offset, size, _: self.chip.load(offset, size), None,
            lambda _uc, offset, size, value, _: self.chip.store(offset, size, value & (1 << 8 * size) - 1), None,
        )  # fmt: skip
        uc.mmio_map(
            0x4200_0000, 0x100_0000,
            lambda _uc, offset, _size, _: self.chip.load_bit(offset), None,
            lambda _uc, offset, _size, value, _: self.chip.store_bit(offset, value), None,
        )  # fmt: skip
        uc.mmio_map(
            0xE000_0000, 0x100000,
            lambda _uc, offset, size, _: self.chip.core.load(offset, size), None,
            lambda _uc, offset, size, value, _: self.chip.core.store(offset, size, value), None,
        )  # fmt: skip
        uc.mmio_map(
            BITS_OF_RAM, 32 * RAM_SIZE,
            lambda _uc, offset, _size, _: self.ram[offset >> 5] >> (offset >> 2 & 7) & 1, None,
            lambda _uc, offset, _size, value, _: self.store_bit(offset, value & 1), None,
        )  # fmt: skip
        for address, size in ELSEWHERE:
            uc.mmio_map(
                address, size,
                lambda _uc, offset, _size, _, base=address: self.chip.load(base - 0x4000_0000 + offset, 4), None,
                lambda _uc, offset, _size, value, _, base=address: self.chip.store(base - 0x4000_0000 + offset, 4, value), None,
            )  # fmt: skip
        uc.hook_add(
            UC_HOOK_MEM_WRITE, lambda _uc, _access, address, size, value, _: self.chip.flash.program(address, size, value),
            None, FLASH, FLASH + FLASH_SIZE - 1,
        )  # fmt: skip
        uc.hook_add(UC_HOOK_MEM_INVALID, lambda _uc, _access, address, _size, _value, _: self.chip.core.refuse(address))
        uc.hook_add(UC_HOOK_INTR, lambda _uc, number, _: self.chip.core.on_interrupt(number))

    def store_bit(self, offset, value):
        """A bit of the RAM (PM0214, 2.2.5)."""
        bit = offset >> 2 & 7
        self.ram[offset >> 5] = self.ram[offset >> 5] & ~(1 << bit) | value << bit

    # Who uses it.

    @classmethod
    def take(cls, image):
        free = cls.free[image.path]
        return free.pop() if free else cls(image)

    def leave(self):
        """Nobody uses it any more."""
        self.chip = None
        self.free[self.image.path].append(self)

    def __deepcopy__(self, _memo):
        """Another engine in the same state; whose it is has to be said."""
        twin = Engine.take(self.image)
        for mine, its in ((self.ram, twin.ram), (self.ccm, twin.ccm)):
            its[:] = mine
        twin.parameters[:] = self.parameters
        twin.map_low(self.has_low_ram)
        twin.state.write(self.state.read())
        return twin

    @property
    def parameters(self):
        begin = PARAMETERS - FLASH
        return self.flash[begin : begin + PARAMETERS_SIZE]

    def clear(self):
        """The core comes out of a reset; memory is as it was."""
        self.state.write([0] * len(STATE))

    # Access rights.

    def allow_all(self):
        if self.is_restricted:
            self.is_restricted = False
            for begin, size in MEMORIES:
                self.uc.mem_protect(begin, size, UC_PROT_ALL)

    def restrict(self, address, size, rights):
        """Where memory is, these rights alone."""
        for begin, length in MEMORIES:
            first, end = max(begin, address), min(begin + length, address + size)
            if first < end:
                self.is_restricted = True
                self.uc.mem_protect(first, end - first, rights)

    # Registers and memory.

    def everything(self):
        """What decides what the program does next."""
        return self.state.read(), bytes(self.ram), bytes(self.ccm)

    def registers(self, numbers):
        return Registers(self.uc, numbers)

    def place(self, address, size):
        """The memory at an address of RAM, and where in it that is; None where there is no RAM."""
        for begin, memory in ((RAM, self.ram), (CCM, self.ccm)):
            if begin <= address <= begin + len(memory) - size:
                return memory, address - begin
        return None
