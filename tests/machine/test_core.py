"""The core of the model: exceptions by short programs, which lie where parameters are stored, and
what a breach tells."""

import pytest
from stm32f405 import Breach, Chip
from stm32f405.engine import PARAMETERS, PARAMETERS_SIZE
from stm32f405.interrupts import IRQ
from unicorn.arm_const import (
    UC_ARM_REG_R0, UC_ARM_REG_R1, UC_ARM_REG_R4, UC_ARM_REG_R5, UC_ARM_REG_R6, UC_ARM_REG_S0, UC_ARM_REG_SP,
)

TABLE, MAIN, HANDLERS, LOG = PARAMETERS, PARAMETERS + 0x1000, PARAMETERS + 0x2000, 0x2001_0000
#: Registers that programs find: where the next byte of the log goes, the register that makes
#: interrupts pending, and what is written to it.
R4, R5, R6 = UC_ARM_REG_R4, UC_ARM_REG_R5, UC_ARM_REG_R6
SET_PENDING = 0xE000_E200

LOOP = "fee7"
#: mrs r0, ipsr; strb r0, [r4]; adds r4, #1
NOTE = "eff30580 2070 0134"
#: str r6, [r5], and longer than a slice: movs r3, #255; subs r3, #1; bne
PEND, WAIT = "2e60", "ff23 013b fdd1"
RETURN = "7047"
CPSID, CPSIE, WFI = "72b6", "62b6", "30bf"

LOW, HIGH = IRQ["SPI1"], IRQ["SPI2"]
#: Both of them in the second register of the controller.
BIT = {irq: 1 << irq - 32 for irq in (LOW, HIGH)}


def basepri(value):
    """movs r0, #value; msr basepri, r0"""
    return f"{value:02x}20 80f31188"


@pytest.fixture
def chip(image):
    chip = Chip(image)
    yield chip
    chip.leave()


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
        for register, value in ((UC_ARM_REG_SP, 0x2000_8000), (R4, LOG), (R5, SET_PENDING + 4), (R6, pends)):
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


def test_the_more_urgent_interrupt_comes_in_the_middle_of_the_other(chip):
    handlers = [(LOW, 0x80, NOTE + PEND + WAIT + NOTE + RETURN), (HIGH, 0x40, NOTE + RETURN)]
    program = Program(chip, "", handlers, pends=BIT[HIGH])
    chip.core.pend(16 + LOW)
    assert program.run().log() == [LOW, HIGH, LOW]
    assert chip.core.uc.reg_read(UC_ARM_REG_SP) == 0x2000_8000


def test_one_that_is_no_more_urgent_comes_behind_it(chip):
    handlers = [(HIGH, 0x40, NOTE + PEND + WAIT + NOTE + RETURN), (LOW, 0x40, NOTE + RETURN)]
    program = Program(chip, "", handlers, pends=BIT[LOW])
    chip.core.pend(16 + HIGH)
    assert program.run().log() == [HIGH, HIGH, LOW]


def test_of_two_that_wait_the_more_urgent_one_is_first_and_then_the_lower_number(chip):
    program = Program(chip, "", [(LOW, 0x80, NOTE + RETURN), (HIGH, 0x40, NOTE + RETURN), (IRQ["SPI3"], 0x80, NOTE + RETURN)])
    for irq in (IRQ["SPI3"], LOW, HIGH):
        chip.core.pend(16 + irq)
    assert program.run().log() == [HIGH, LOW, IRQ["SPI3"]]


@pytest.mark.parametrize(
    ("mask", "comes"),
    [("", [LOW]), (CPSID, []), (CPSID + WAIT + CPSIE, [LOW]), (basepri(0x80), []), (basepri(0x90), [LOW]), (basepri(0x80) + WAIT + basepri(0), [LOW])],
    ids=["nothing", "PRIMASK", "PRIMASK, and off again", "BASEPRI at its priority", "BASEPRI below it", "BASEPRI, and off again"],
)
def test_what_is_masked_waits_until_it_is_not(chip, mask, comes):
    program = Program(chip, mask + PEND + WAIT + WAIT, [(LOW, 0x80, NOTE + RETURN)], pends=BIT[LOW])
    assert program.run().log() == comes
    assert (16 + LOW in chip.core.system.pending) == (comes == [])


def test_a_masked_interrupt_ends_a_sleep(chip):
    program = Program(chip, CPSID + WFI + NOTE, [(LOW, 0x80, NOTE + RETURN)])
    program.run()
    assert chip.core.sleeping and program.log() == []
    chip.core.pend(16 + LOW)
    # The main program notes itself as exception 0, the handler nothing.
    assert program.run().log() == [-16]


def test_a_handler_that_uses_the_fpu_leaves_the_registers_of_who_was_there(chip):
    # vmov s0, r0 with 7 in main, with its own number in the handler.
    program = Program(chip, "0720 00ee100a" + PEND + WAIT, [(LOW, 0x80, NOTE + "00ee100a" + RETURN)], pends=BIT[LOW])
    sizes = []
    enter = chip.core.enter
    chip.core.enter = lambda number: (enter(number), sizes.append(chip.core.active[-1][2][0]))
    assert program.run().log() == [LOW]
    assert chip.core.uc.reg_read(UC_ARM_REG_S0) == 7
    # A frame with the registers of the FPU.
    assert sizes == [0x68]


@pytest.mark.parametrize("together", [True, False], ids=["one behind the other", "each for itself"])
def test_an_exception_behind_another_costs_no_second_frame(chip, together):
    program = Program(chip, "", [(LOW, 0x80, RETURN), (HIGH, 0x80, RETURN)])
    chip.core.count_cost()
    program.run()
    costs, enter = [], chip.core.enter

    def counted(number):
        before = chip.core.stall
        enter(number)
        costs.append(chip.core.stall - before)

    chip.core.enter = counted
    for irq in (LOW, HIGH):
        chip.core.pend(16 + irq)
        if not together:
            program.run()
    program.run()
    # The way back, 12 as well, has been counted by then.
    assert costs == ([12, 6 - 12] if together else [12, 12])


def test_systick_comes_again_and_again_to_the_clock(chip):
    program, system = Program(chip, "", [(15 - 16, 0, RETURN)]), chip.core.system
    times, tick = [], system.tick
    system.tick = lambda time: (times.append(time), tick(time))
    system.store(0xE014, 4, 999)
    system.store(0xE010, 4, 7)
    program.run(10_500)
    assert chip.core.counts[15] == 10
    assert all(abs(after - before - 1_000) <= 400 for before, after in zip(times, times[1:]))


def test_a_bit_has_an_address_of_its_own(chip):
    # RCC_AHB1ENR, bits 1 and 2.
    for bit in (1, 2):
        chip.store_bit(0x2_3830 * 32 + 4 * bit, 1)
    assert chip.rcc["AHB1ENR"] & 7 == 6
    assert chip.load_bit(0x2_3830 * 32 + 4) == 1
    chip.store_bit(0x2_3830 * 32 + 4, 0)
    assert chip.rcc["AHB1ENR"] & 7 == 4
    chip.check()


@pytest.mark.parametrize("address", [0x4000_4400, 0x2200_0000, 0x5000_0000, 0x6000_0000, 0xA000_0000, 0xE000_1004, 0x4002_4000, 0x4001_4800])
@pytest.mark.parametrize("code", ["0860", "0868"], ids=["str", "ldr"])
def test_what_is_not_modelled_is_told_with_its_place(chip, address, code):
    """A USART, bits of the RAM, AHB2, external memory and its controller, the cycle counter, the
    backup RAM, a timer: not one is storage."""
    # nop; str or ldr r0, [r1]
    program = Program(chip, "00bf" + code)
    chip.core.uc.reg_write(UC_ARM_REG_R0, 1)
    chip.core.uc.reg_write(UC_ARM_REG_R1, address)
    with pytest.raises(Breach, match=f"{MAIN + 2:#010x}"):
        program.run()


def test_a_breach_tells_function_and_source_line(bench):
    bench.chip.rcc["APB1ENR"] &= ~2
    with pytest.raises(Breach, match=r"TIM3: SR .* without the clock of its peripheral\n  at 0x080[0-9a-f]{5} \S+ \(\S+\.rs:\d+\)"):
        bench.milliseconds(2)


def test_an_address_without_anything_is_a_hard_fault(chip):
    program = Program(chip, "0868", [(3 - 16, 0, NOTE + LOOP)])
    chip.core.uc.reg_write(UC_ARM_REG_R1, 0x3000_0000)
    assert program.run().log() == [3 - 16]
