"""Edges of pins (RM0090, 9 and 12): SYSCFG chooses the port of each line, EXTI sees its edges. SYSCFG chooses too what is at address 0."""

from .interrupts import IRQ
from .registers import Peripheral, Register

LINES = 0x7F_FFFF

#: MEMRMP: RAM at 0.
LOW_RAM = 3


class Syscfg(Peripheral):
    NAME = "SYSCFG"
    WRITE_SIZES = (1, 2, 4)
    CLOCK = (0x44, 14)
    REGISTERS = {0x00: Register("MEMRMP", 3)} | {0x08 + 4 * i: Register(f"EXTICR{i + 1}", 0xFFFF) for i in range(4)}

    def reset(self):
        super().reset()
        self.chip.engine.map_low(False)

    def write_MEMRMP(self, value):
        if value not in (0, LOW_RAM):
            self.breach(f"MEMRMP {value}: the system memory or one outside at 0 is not modelled")
        if value == LOW_RAM and not self.chip.core.system.stored[0xED08]:
            self.breach("RAM at 0, where vectors are fetched from")
        self["MEMRMP"] = value
        self.chip.engine.map_low(value == LOW_RAM)

    def port(self, line):
        # Its registers need a clock, what they choose does not.
        return "ABCDEFGHI"[self[f"EXTICR{line // 4 + 1}"] >> 4 * (line % 4) & 15]


class Exti(Peripheral):
    NAME = "EXTI"
    READ_SIZES = WRITE_SIZES = (4,)
    REGISTERS = {
        0x00: Register("IMR", LINES),
        0x08: Register("RTSR", LINES),
        0x0C: Register("FTSR", LINES),
        0x14: Register("PR", 0, rc_w1=LINES),
    }

    def write_IMR(self, value):
        for line in range(16):
            if (value & ~self["IMR"]) >> line & 1:
                self.chip.pins.floats(f"P{self.chip.syscfg.port(line)}{line}", f"interrupt line {line}")
        self["IMR"] = value

    #: By interrupt, its lines. 16 is the supply supervisor.
    INTERRUPTS = {IRQ["PVD"]: 1 << 16, IRQ["EXTI9_5"]: 0x3E0, IRQ["EXTI15_10"]: 0xFC00} | {IRQ[f"EXTI{i}"]: 1 << i for i in range(5)}

    def edge(self, port, pin, level):
        if self.chip.syscfg.port(pin) == port and self["RTSR" if level else "FTSR"] >> pin & 1:
            self["PR"] |= 1 << pin

    def internal(self, line, level):
        """An edge of a line without a pin: 16 is the supply supervisor."""
        if self["RTSR" if level else "FTSR"] >> line & 1:
            self["PR"] |= 1 << line

    def lines(self):
        pending = self.r[0x14] & self.r[0x00]
        if not pending:
            return ()
        return [irq for irq, lines in self.INTERRUPTS.items() if pending & lines]
