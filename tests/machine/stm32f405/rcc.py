"""Reset and clock control (RM0090, 7): the clock tree, and which peripheral has a clock."""

from .clock import HZ, NEVER, US
from .registers import Peripheral, Register

HSEON, HSERDY, CSSON, PLLON, PLLRDY = 1 << 16, 1 << 17, 1 << 19, 1 << 24, 1 << 25
CSSF, CSSC = 1 << 7, 1 << 23

#: After a reset some of the prescaler bits of PLLCFGR are set.
PLLCFGR_RESET = 0x2400_3010

#: The bits of what is modelled: ports and DMA2; TIM2, TIM3, TIM5, SPI2, SPI3, USART2 to UART4, CAN1, PWR; TIM1, USART1, ADC1 to ADC3, SPI1, SYSCFG.
AHB1, APB1, APB2 = 0x0040_01FF, 1 << 28 | 1 << 25 | 7 << 17 | 3 << 14 | 0b1011, 1 << 14 | 1 << 12 | 7 << 8 | 1 << 4 | 1


class Rcc(Peripheral):
    NAME = "RCC"
    WRITE_SIZES = (1, 2, 4)
    REGISTERS = {
        0x00: Register("CR", 0x050D_00F9, 0x83, keep=False, known=HSEON | CSSON | PLLON | 1),
        0x04: Register("PLLCFGR", 0x0F43_7FFF, PLLCFGR_RESET),
        0x08: Register("CFGR", 0xFFFF_FCF3, 0, keep=False, known=0xFCF3),
        0x0C: Register("CIR", 0x003F_3F00, 0, keep=False, known=0),
        0x10: Register("AHB1RSTR", 0x2260_11FF, known=AHB1),
        0x20: Register("APB1RSTR", 0x36FE_C9FF, known=APB1),
        0x24: Register("APB2RSTR", 0x0007_5933, known=APB2 & ~(3 << 9)),
        0x30: Register("AHB1ENR", 0x7E74_11FF, 0x0010_0000, known=AHB1),
        0x40: Register("APB1ENR", 0x36FE_C9FF, known=APB1),
        0x44: Register("APB2ENR", 0x0007_5F33, known=APB2),
    }
    #: The reset register of each enable register.
    RESETS = {0x10: 0x30, 0x20: 0x40, 0x24: 0x44}

    def __init__(self, chip):
        self.nmi = False
        self.crystal_at = self.pll_at = NEVER
        self.crystal_dies = False
        super().__init__(chip)

    def write_CR(self, value):
        old = self["CR"]
        flags = old & (HSERDY | PLLRDY | 2)
        if value & HSEON and not old & HSEON and self.chip.crystal:
            self.crystal_at = self.chip.now() + 1000 * US
        if value & PLLON and not old & PLLON:
            source = self["PLLCFGR"] >> 22 & 1
            if source and not flags & HSERDY:
                self.breach("the PLL is switched on before its crystal is ready")
            self.check_pll()
            self.pll_at = self.chip.now() + 100 * US
        if not value & HSEON:
            if self["CFGR"] >> 2 & 3 == 1 or self["CFGR"] >> 2 & 3 == 2 and self["PLLCFGR"] >> 22 & 1:
                self.breach("the crystal is switched off while the core runs from it")
            flags &= ~HSERDY
        if not value & PLLON:
            if self["CFGR"] >> 2 & 3 == 2:
                self.breach("the PLL is switched off while the core runs from it")
            flags &= ~PLLRDY
        flags |= (value & 1) << 1
        self["CR"] = value & ~(HSERDY | PLLRDY | 2) | flags

    def check_pll(self):
        """The limits of each stage (RM0090, 7.3.2)."""
        v = self["PLLCFGR"]
        m, n, p, q = v & 63, v >> 6 & 511, 2 * (v >> 16 & 3) + 2, v >> 24 & 15
        source = 8_000_000 if v >> 22 & 1 else 16_000_000
        if m < 2 or not 50 <= n <= 432 or q < 2:
            return self.breach(f"PLLCFGR {v:#x} has a divider that is not allowed")
        if not 1_000_000 <= source / m <= 2_000_000 or not 100e6 <= source / m * n <= 432e6:
            self.breach(f"PLLCFGR {v:#x}: the VCO is out of its range")
        self.pll_hz = source // m * n // p

    def write_PLLCFGR(self, value):
        if self["CR"] & PLLON:
            self.breach("PLLCFGR written while the PLL is on")
        self["PLLCFGR"] = value

    def write_CFGR(self, value):
        switch = value & 3
        ready = {0: 2, 1: HSERDY, 2: PLLRDY}.get(switch)
        if ready is None or not self["CR"] & ready:
            self.breach(f"CFGR chooses clock {switch}, which is not ready")
        elif switch == 2:
            self.check_tree(value)
        self["CFGR"] = value & ~0xC | switch << 2

    def check_tree(self, cfgr):
        """The clocks that the rest of this model counts on, and flash that is as slow as it must be."""
        divider = lambda bits, least: 2 ** max(0, bits - least + 1) if bits >= least else 1
        core = self.pll_hz // divider(cfgr >> 4 & 15, 8)
        apb1 = core // divider(cfgr >> 10 & 7, 4)
        apb2 = core // divider(cfgr >> 13 & 7, 4)
        if (core, apb1, apb2) != (HZ, HZ // 4, HZ // 2):
            self.breach(f"core {core} Hz, APB1 {apb1} Hz, APB2 {apb2} Hz, where the model has 168, 42 and 84 MHz")
        if self.chip.flash["ACR"] & 15 < 5:
            self.breach("168 MHz with less than 5 wait states of the flash")

    def write_CIR(self, value):
        if value & CSSC:
            self.nmi = False
        self["CIR"] = value & 0x3F00

    def read_CIR(self):
        return self["CIR"] | (CSSF if self.nmi else 0)

    def store(self, offset, size, value):
        # The clear bit of the clock security system shares its word with flags.
        if offset == 0x0C and value & CSSC:
            self.nmi = False
            value &= ~CSSC
        super().store(offset, size, value)
        enable = self.RESETS.get(offset & ~3)
        if enable is not None:
            for peripheral in self.chip.peripherals:
                if peripheral.CLOCK and peripheral.CLOCK[0] == enable and self.r[offset & ~3] >> peripheral.CLOCK[1] & 1:
                    peripheral.reset()

    def fail_crystal(self):
        """The crystal stops. With the clock security system the chip falls back to its RC oscillator and raises NMI; without it the core
        has no clock any more."""
        self.chip.crystal = False
        self.chip.core.loops = False
        self["CR"] &= ~(HSERDY | HSEON | PLLON | PLLRDY)
        if self["CR"] & CSSON:
            self["CFGR"] &= ~0xF
            self.nmi = True
        else:
            self.chip.core.is_stopped = True

    def next_event(self):
        return min(self.crystal_at, self.pll_at)

    def event(self):
        now = self.chip.time
        if self.crystal_at <= now:
            self.crystal_at = NEVER
            self["CR"] |= HSERDY
        if self.pll_at <= now:
            self.pll_at = NEVER
            self["CR"] |= PLLRDY


class Pwr(Peripheral):
    """Power control (RM0090, 5): the supply supervisor, nothing else."""

    NAME = "PWR"
    CLOCK = (0x40, 28)
    #: CR: VOS, PVD level and enable.
    REGISTERS = {
        0x00: Register("CR", 0x0000_C3FF, 0x0000_C000, known=0xF0),
        0x04: Register("CSR", 0x0000_0300, 0, keep=False),
    }
