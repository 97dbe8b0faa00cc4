"""What all peripherals have: registers with names, and rules that are held."""

from .clock import NEVER


class Breach(AssertionError):
    """The image did what the manuals forbid, or touched what is not modelled."""


class Register:
    """One register: its name, the bits that may be written, and its value after a reset.

    `clears`: bits that are cleared by writing 0 (`rc_w0`) or 1 (`rc_w1`) to them. Bits outside of
    `bits` are reserved or read-only: they may be written only as they are. Bits outside of `known`
    mean something on the chip and nothing here: they must stay as they are after a reset."""

    def __init__(self, name, bits=0xFFFF_FFFF, reset=0, rc_w0=0, rc_w1=0, keep=True, known=0xFFFF_FFFF):
        self.name, self.bits, self.reset = name, bits, reset
        self.rc_w0, self.rc_w1 = rc_w0, rc_w1
        #: Reserved bits are to be kept as they are; otherwise they are ignored (read-only flags beside `rc` flags).
        self.keep = keep
        self.may_write = bits | rc_w0 | rc_w1
        self.unknown = bits & ~known


def read_only(name, reset=0):
    return Register(name, 0, reset)


class Peripheral:
    """A block of registers on a bus. `REGISTERS` maps offsets to them; a method `read_NAME` or `write_NAME` does what is more than storage."""

    NAME = "?"
    REGISTERS = {}
    #: Sizes of accesses in bytes that the bus takes.
    READ_SIZES = (1, 2, 4)
    WRITE_SIZES = (2, 4)
    #: Where RCC has its clock and its reset: the offset of the enable register and the bit. `None`: it always has one.
    CLOCK = None

    def __init__(self, chip):
        self.chip = chip
        self.r = {}
        self.readers = {o: getattr(self, "read_" + reg.name, None) for o, reg in self.REGISTERS.items()}
        self.writers = {o: getattr(self, "write_" + reg.name, None) for o, reg in self.REGISTERS.items()}
        self.offset = {reg.name: o for o, reg in self.REGISTERS.items()}
        self.reset()

    def reset(self):
        self.r = {o: reg.reset for o, reg in self.REGISTERS.items()}

    def __getitem__(self, name):
        return self.r[self.offset[name]]

    def __setitem__(self, name, value):
        self.r[self.offset[name]] = value

    def breach(self, text):
        self.chip.breach(f"{self.NAME}: {text}")

    def has_clock(self):
        clock = self.CLOCK
        return clock is None or self.chip.rcc.r[clock[0]] >> clock[1] & 1

    # The bus.

    def load(self, offset, size):
        word = offset & ~3
        register = self.REGISTERS.get(word)
        if register is None:
            self.breach(f"offset {offset:#x} read, which is not modelled")
            return 0
        if size not in self.READ_SIZES:
            self.breach(f"{register.name} read with {size} bytes")
        if not self.has_clock():
            self.breach(f"{register.name} read without the clock of its peripheral")
            return 0
        reader = self.readers[word]
        value = self.r[word] if reader is None else reader()
        return value if size == 4 else value >> 8 * (offset & 3) & (1 << 8 * size) - 1

    def store(self, offset, size, value):
        word = offset & ~3
        register = self.REGISTERS.get(word)
        if register is None:
            self.breach(f"offset {offset:#x} written with {value:#x}, which is not modelled")
            return
        if size not in self.WRITE_SIZES:
            self.breach(f"{register.name} written with {size} bytes")
        if not self.has_clock():
            self.breach(f"{register.name} written without the clock of its peripheral")
            return
        if size < 4:
            value = self.widen(word, offset & 3, size, value)
        old = self.r[word]
        if register.keep and (old ^ value) & ~register.may_write:
            self.breach(
                f"{register.name} written with {value:#x}: reserved bits {(old ^ value) & ~register.may_write:#x} changed from {old:#x}"
            )
        if unknown := (register.reset ^ value) & register.unknown:
            self.breach(f"{register.name} written with {value:#x}: what bits {unknown:#x} do is not modelled")
        flags = old & (register.rc_w0 | register.rc_w1) & (value | ~register.rc_w0) & ~(value & register.rc_w1)
        kept = ~(register.bits | register.rc_w0 | register.rc_w1)
        value = value & register.bits | flags | old & kept
        writer = self.writers[word]
        if writer is None:
            self.r[word] = value
        else:
            writer(value)

    def widen(self, word, byte, size, value):
        """What a narrow write does to the whole register."""
        mask = (1 << 8 * size) - 1 << 8 * byte
        return self.r[word] & ~mask | value << 8 * byte & mask

    # Time and interrupts.

    def next_event(self):
        """When it does something of itself."""
        return NEVER

    def event(self):
        """It is that moment."""

    def lines(self):
        """The interrupts that it asks for."""
        return ()
