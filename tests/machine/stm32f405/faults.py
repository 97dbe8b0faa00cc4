"""Faults of the core, and the MPU that makes some of them (PM0214, 2.4 and 4.2 to 4.5)."""

from unicorn import (
    UC_ERR_FETCH_PROT, UC_ERR_FETCH_UNMAPPED, UC_ERR_READ_PROT, UC_ERR_WRITE_PROT, UC_PROT_ALL, UC_PROT_EXEC, UC_PROT_NONE, UC_PROT_READ,
    UC_PROT_WRITE,
)  # fmt: skip

from .engine import PAGE

MEMORY, BUS, USAGE = 4, 5, 6

#: Bits of CFSR.
IACCVIOL, DACCVIOL, MSTKERR, MMARVALID = 1, 1 << 1, 1 << 4, 1 << 7
IBUSERR, PRECISERR, STKERR, BFARVALID = 1 << 8, 1 << 9, 1 << 12, 1 << 15
UNDEFINSTR, INVSTATE, NOCP, UNALIGNED = 1 << 16, 1 << 17, 1 << 19, 1 << 24
FORCED = 1 << 30

#: What unicorn's interrupt hook tells, beside what is none.
TOLD = {17: NOCP, 18: INVSTATE, 22: UNALIGNED}


class Faults:
    """SHCSR, CFSR, HFSR and the addresses. `mpu` is what forbids accesses."""

    def __init__(self, system):
        self.system, self.core, self.chip = system, system.core, system.chip
        self.enabled, self.status, self.hard, self.memory_at, self.bus_at = 0, 0, 0, 0, 0
        #: Where the access was that unicorn has refused.
        self.refused = 0
        self.mpu = Mpu(self)

    def load(self, offset):
        return {0xED24: self.enabled, 0xED28: self.status, 0xED2C: self.hard, 0xED34: self.memory_at, 0xED38: self.bus_at}[offset]

    def store(self, offset, value):
        if offset == 0xED24:
            if value & ~(7 << 16):
                self.chip.breach(f"SHCSR written with {value:#x}: more than the enables is not modelled")
            self.enabled = value & 7 << 16
        elif offset == 0xED28:
            self.status &= ~value
        elif offset == 0xED2C:
            self.hard &= ~value
        else:
            self.chip.breach(f"core register {0xE000_0000 + offset:#x} written with {value:#x}, which is not modelled")

    def of_access(self, error):
        """unicorn has refused something."""
        number = error.errno
        if number in (UC_ERR_READ_PROT, UC_ERR_WRITE_PROT):
            self.memory_at = self.refused
            self.take(MEMORY, DACCVIOL | MMARVALID)
        elif number == UC_ERR_FETCH_PROT:
            self.take(MEMORY, IACCVIOL)
        elif number == UC_ERR_FETCH_UNMAPPED:
            self.take(BUS, IBUSERR)
        elif self.refused:
            self.bus_at = self.refused
            self.take(BUS, PRECISERR | BFARVALID)
        else:
            self.take(USAGE, UNDEFINSTR)

    def of_instruction(self, told):
        self.take(USAGE, TOLD.get(told, UNDEFINSTR))

    def take(self, number, bits):
        """By its own handler if that is on and more urgent than what runs, else by that of hard faults."""
        self.status |= bits
        self.refused = 0
        core = self.core
        if self.enabled >> 12 + number & 1 and self.system.priority[number] < core.current_priority(*core.views.masks.read()):
            core.enter(number)
        else:
            self.hard |= FORCED
            core.hard_fault()


class Mpu:
    """Eight regions. unicorn holds them, whose pages have 1 KiB: smaller ones are breaches, so are parts of regions, and a map
    without its background."""

    def __init__(self, faults):
        self.faults, self.chip = faults, faults.chip
        self.control, self.number = 0, 0
        self.regions = [(0, 0)] * 8
        self.chip.engine.allow_all()

    def load(self, offset):
        if offset == 0xED90:
            return len(self.regions) << 8
        if offset == 0xED94:
            return self.control
        if offset == 0xED98:
            return self.number
        base, attributes = self.regions[self.number]
        return base | self.number if offset % 8 == 4 else attributes

    def store(self, offset, value):
        if offset == 0xED94:
            if value & 1 and not value & 4:
                self.chip.breach("an MPU without PRIVDEFENA is not modelled")
            self.control = value & 7
        elif offset == 0xED98:
            self.number = value & 7
        elif offset == 0xED90:
            self.chip.breach("the type of the MPU is written")
        elif offset % 8 == 4:
            if value & 0x10:
                self.number = value & 7
            self.regions[self.number] = value & ~0x1F, self.regions[self.number][1]
        else:
            self.regions[self.number] = self.regions[self.number][0], value
        self.apply()

    def extent(self, region):
        base, attributes = region
        size = 2 << (attributes >> 1 & 31)
        return base & ~(size - 1), size

    def rights(self, attributes):
        access = attributes >> 24 & 7
        if access == 4:
            self.chip.breach("an access permission of the MPU that is reserved")
        data = UC_PROT_NONE if access == 0 else UC_PROT_READ if access > 4 else UC_PROT_READ | UC_PROT_WRITE
        return data | (0 if attributes >> 28 & 1 or access == 0 else UC_PROT_EXEC)

    def is_on(self):
        """In the handler of hard faults and NMI it is off, unless HFNMIENA."""
        active = self.faults.core.active
        return self.control & 1 and (self.control & 2 or not (active and active[-1][1] < 0))

    def apply(self):
        """A region with a higher number goes before."""
        engine = self.chip.engine
        engine.allow_all()
        if not self.is_on():
            return
        for region in self.regions:
            if not region[1] & 1:
                continue
            begin, size = self.extent(region)
            rights = self.rights(region[1])
            if size < PAGE or region[1] & 0xFF00:
                self.chip.breach(f"a region of the MPU of {size} bytes, or of parts, is not modelled")
            elif begin + size > 0x4000_0000 and rights & 3 != 3:
                self.chip.breach("a region of the MPU that takes peripherals away is not modelled")
            else:
                engine.restrict(begin, size, rights)

    def refuses(self, address, size):
        """Whether a frame cannot be stacked there."""
        if not self.is_on():
            return False
        rights = UC_PROT_ALL
        for region in self.regions:
            begin, extent = self.extent(region)
            if region[1] & 1 and begin < address + size and address < begin + extent:
                rights = self.rights(region[1])
        return not rights & UC_PROT_WRITE
