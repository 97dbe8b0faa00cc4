"""Short programs for the core of the model, which lie where parameters are stored."""

from stm32f405.engine import PARAMETERS, PARAMETERS_SIZE
from stm32f405.interrupts import IRQ
from unicorn.arm_const import UC_ARM_REG_R4, UC_ARM_REG_R5, UC_ARM_REG_R6, UC_ARM_REG_R7, UC_ARM_REG_SP

TABLE, MAIN, HANDLERS, LOG, STACK = PARAMETERS, PARAMETERS + 0x1000, PARAMETERS + 0x2000, 0x2001_0000, 0x2000_8000
#: Registers that programs find: where the next byte of the log goes, the register that makes
#: interrupts pending, and what is written to it.
R4, R5, R6, R7 = UC_ARM_REG_R4, UC_ARM_REG_R5, UC_ARM_REG_R6, UC_ARM_REG_R7
SET_PENDING = 0xE000_E200

LOOP = "fee7"
#: mrs r0, ipsr; strb r0, [r4]; adds r4, #1
NOTE = "eff30580 2070 0134"
#: str r6, [r5], and longer than a slice: movs r3, #255; subs r3, #1; bne
PEND, WAIT = "2e60", "ff23 013b fdd1"
RETURN = "7047"
#: vmov s0, r0
FLOAT = "00ee100a"
CPSID, CPSIE, WFI = "72b6", "62b6", "30bf"

LOW, HIGH = IRQ["SPI1"], IRQ["SPI2"]
#: Both of them in the second register of the controller.
BIT = {irq: 1 << irq - 32 for irq in (LOW, HIGH)}


def basepri(value):
    """movs r0, #value; msr basepri, r0"""
    return f"{value:02x}20 80f31188"


class Program:
    """`main` with handlers of exceptions: of interrupts, each with its priority, and of others
    (negative numbers)."""

    def __init__(self, chip, main, handlers=(), pends=0):
        self.chip, self.core = chip, chip.core
        uc = chip.core.uc
        self.put(MAIN, bytes.fromhex(main + LOOP))
        chip.core.system.stored[0xED08] = TABLE
        for i, (irq, priority, code) in enumerate(handlers):
            at = HANDLERS + 0x100 * i
            self.put(at, bytes.fromhex(code))
            self.put(TABLE + 4 * (16 + irq), (at | 1).to_bytes(4, "little"))
            if irq >= 0:
                chip.core.system.enabled.add(irq)
                chip.core.system.priority[16 + irq] = priority
        # What another test has had there is translated already.
        uc.ctl_remove_cache(PARAMETERS, PARAMETERS + PARAMETERS_SIZE)
        for register, value in ((UC_ARM_REG_SP, STACK), (R4, LOG), (R5, SET_PENDING + 4), (R6, pends)):
            uc.reg_write(register, value)
        chip.core.pc = MAIN | 1

    def put(self, address, data):
        offset = address - PARAMETERS
        self.chip.engine.parameters[offset : offset + len(data)] = data

    def run(self, clocks=5_000):
        self.chip.run(clocks)
        return self

    def log(self):
        """The numbers of the interrupts in the order in which handlers have noted themselves."""
        end = self.core.uc.reg_read(R4)
        return [number - 16 for number in self.core.uc.mem_read(LOG, end - LOG)]
