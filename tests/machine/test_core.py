"""The core of the model: exceptions by short programs, and what a breach tells."""

import pytest
from program import BIT, CPSID, CPSIE, FLOAT, HIGH, LOG, LOOP, LOW, MAIN, NOTE, PEND, RETURN, WAIT, WFI, Program, basepri
from stm32f405 import Breach, Chip
from stm32f405.interrupts import IRQ
from unicorn.arm_const import UC_ARM_REG_R0, UC_ARM_REG_R1, UC_ARM_REG_S0, UC_ARM_REG_SP


@pytest.fixture
def chip(image):
    chip = Chip(image)
    yield chip
    chip.leave()


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
    program = Program(chip, "0720" + FLOAT + PEND + WAIT, [(LOW, 0x80, NOTE + FLOAT + RETURN)], pends=BIT[LOW])
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


def test_a_bit_of_the_ram_has_an_address_of_its_own(chip):
    # str r0, [r1]; ldr r0, [r1]; and what has been read into the log: RAM is A5h behind a power-on.
    for bit, value, byte in ((1, 1, 0xA7), (0, 0, 0xA6), (7, 0, 0x26)):
        program = Program(chip, "0860 0868 2070 0134")
        for register, content in ((UC_ARM_REG_R0, value), (UC_ARM_REG_R1, 0x2200_0000 + 32 * 0x1_2345 + 4 * bit)):
            chip.core.uc.reg_write(register, content)
        program.run(100)
        assert chip.core.uc.mem_read(LOG, 1)[0] == value
        assert chip.engine.ram[0x1_2345] == byte


@pytest.mark.parametrize("address", [0x4000_5400, 0x2240_0000, 0x5000_0000, 0x6000_0000, 0xA000_0000, 0xE000_0E80, 0x4002_4000, 0x4001_4800])
@pytest.mark.parametrize("code", ["0860", "0868"], ids=["str", "ldr"])
def test_what_is_not_modelled_is_told_with_its_place(chip, address, code):
    """I2C, bits of more RAM than there is, AHB2, external memory and its controller, the trace of the core,
    the backup RAM, a timer: not one is storage."""
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
