"""What the core of the model has beside exceptions, by short programs: the FPU's way of stacking, faults, the MPU, the cycle counter,
sleep behind a handler, a reset by software. The image uses of it what a start and a sleep take, and no more."""

import pytest
from program import BIT, FLOAT, HIGH, LOG, LOOP, LOW, MAIN, NOTE, PEND, R7, RETURN, STACK, WAIT, Program
from stm32f405 import Breach, Chip
from stm32f405.faults import BFARVALID, DACCVIOL, FORCED, IACCVIOL, MMARVALID, MSTKERR, PRECISERR, UNDEFINSTR
from unicorn.arm_const import UC_ARM_REG_R0, UC_ARM_REG_R1, UC_ARM_REG_S0, UC_ARM_REG_SP

ICSR, AIRCR, SCR, SHCSR, CFSR, HFSR, MMFAR, BFAR = 0xED04, 0xED0C, 0xED10, 0xED24, 0xED28, 0xED2C, 0xED34, 0xED38
MPU_CTRL, MPU_RNR, MPU_RBAR, MPU_RASR = 0xED94, 0xED98, 0xED9C, 0xEDA0
FPCCR, FPCAR, DEMCR, DWT_CTRL, DWT_CYCCNT = 0xEF34, 0xEF38, 0xEDFC, 0x1000, 0x1004
HARD_FAULT, MEMORY, BUS, USAGE, PENDSV = 3, 4, 5, 6, 14

#: str r0, [r1] and ldr r0, [r1]; ldr r0, [r7] and its lowest byte into the log.
STORE, LOAD = "0860", "0868"
NOTE_R7 = "3868 2070 0134"
SEVEN = "0720"

GUARD = 0x2000_4000


@pytest.fixture
def chip(image):
    chip = Chip(image)
    yield chip
    chip.leave()


def handlers(*numbers):
    return [(number - 16, 0, NOTE + LOOP) for number in numbers]


def at(program, address):
    program.core.uc.reg_write(UC_ARM_REG_R1, address)
    return program


def test_registers_of_the_fpu_are_stacked_when_a_handler_needs_them(chip):
    code = NOTE_R7 + WAIT + WAIT + FLOAT + WAIT + WAIT + NOTE_R7 + RETURN
    program = Program(chip, SEVEN + FLOAT + PEND + WAIT, [(LOW, 0x80, code)], pends=BIT[LOW])
    chip.core.uc.reg_write(R7, 0xE000_0000 + FPCCR)
    room = slice(STACK - 0x48 - 0x2000_0000, STACK - 0x2000_0000)
    seen = []
    enter = chip.core.enter
    chip.core.enter = lambda number: (enter(number), seen.append(bytes(chip.engine.ram[room])))
    program.run()
    assert list(chip.core.uc.mem_read(LOG, 2)) == [1, 0]
    # Nothing was there at the entry of the handler, what the main program had in S0 is there now.
    assert seen == [b"\xa5" * 0x48]
    assert bytes(chip.engine.ram[room])[:4] == b"\7\0\0\0"
    assert chip.core.system.load(FPCAR, 4) == STACK - 0x48
    assert chip.core.uc.reg_read(UC_ARM_REG_S0) == 7
    chip.check()


def test_a_handler_without_floats_stacks_none(chip):
    program = Program(chip, SEVEN + FLOAT + PEND + WAIT, [(LOW, 0x80, NOTE + RETURN)], pends=BIT[LOW])
    assert program.run().log() == [LOW]
    assert bytes(chip.engine.ram[STACK - 0x48 - 0x2000_0000 : STACK - 0x2000_0000]) == b"\xa5" * 0x48
    assert chip.core.system.load(FPCCR, 4) == 0xC000_0000
    assert chip.core.uc.reg_read(UC_ARM_REG_S0) == 7


@pytest.mark.parametrize("outer", ["", FLOAT], ids=["the inner one alone", "both"])
def test_handlers_in_each_other_leave_the_floats_of_the_main_program(chip, outer):
    """The inner one uses the FPU while the outer one's room is still empty, or has been filled."""
    nested = [(LOW, 0x80, NOTE + outer + PEND + WAIT + WAIT + RETURN), (HIGH, 0x40, NOTE + FLOAT + WAIT + RETURN)]
    program = Program(chip, SEVEN + FLOAT, nested, pends=BIT[HIGH])
    program.run()
    chip.core.pend(16 + LOW)
    assert program.run().log() == [LOW, HIGH]
    assert chip.core.uc.reg_read(UC_ARM_REG_S0) == 7
    assert chip.core.uc.reg_read(UC_ARM_REG_SP) == STACK


@pytest.mark.parametrize("enabled", [True, False])
@pytest.mark.parametrize(
    ("code", "number", "status", "address"),
    [(LOAD, BUS, PRECISERR | BFARVALID, BFAR), ("00de", USAGE, UNDEFINSTR, None)],
    ids=["an address without anything", "an instruction that is none"],
)
def test_a_fault_says_what_it_is_and_comes_to_its_handler_or_to_that_of_hard_faults(chip, code, number, status, address, enabled):
    program = at(Program(chip, code, handlers(HARD_FAULT, number)), 0x3000_0000)
    system = chip.core.system
    if enabled:
        system.store(SHCSR, 4, 7 << 16)
    assert program.run().log() == [(number if enabled else HARD_FAULT) - 16]
    assert system.load(CFSR, 4) == status
    assert system.load(HFSR, 4) == (0 if enabled else FORCED)
    assert address is None or system.load(address, 4) == 0x3000_0000
    # The frame has the instruction itself.
    frame = chip.core.uc.reg_read(UC_ARM_REG_SP)
    assert int.from_bytes(chip.core.uc.mem_read(frame + 24, 4), "little") == MAIN
    system.store(CFSR, 4, status)
    assert system.load(CFSR, 4) == 0


def protect(chip, address, attributes, number=0):
    """A region of 1 KiB, with the map behind it."""
    system = chip.core.system
    system.store(SHCSR, 4, 7 << 16)
    system.store(MPU_RNR, 4, number)
    system.store(MPU_RBAR, 4, address)
    system.store(MPU_RASR, 4, attributes | 9 << 1 | 1)
    system.store(MPU_CTRL, 4, 5)


NONE, READ_ONLY, FULL, NOT_EXECUTED = 0, 6 << 24, 3 << 24, 1 << 28


@pytest.mark.parametrize(
    ("address", "rights", "code", "ends"),
    [
        (GUARD, NONE, STORE, True), (GUARD + 0x3FC, NONE, LOAD, True), (GUARD - 4, NONE, STORE, False), (GUARD + 0x400, NONE, STORE, False),
        (GUARD, READ_ONLY, LOAD, False), (GUARD, READ_ONLY, STORE, True), (GUARD, FULL, STORE, False),
    ],
)  # fmt: skip
def test_the_mpu_forbids_what_a_region_says(chip, address, rights, code, ends):
    program = at(Program(chip, code + NOTE, handlers(MEMORY)), address)
    protect(chip, GUARD, rights)
    # The main program notes itself as exception 0.
    assert program.run().log() == [MEMORY - 16 if ends else -16]
    system = chip.core.system
    assert (system.load(CFSR, 4), system.load(MMFAR, 4)) == ((DACCVIOL | MMARVALID, address) if ends else (0, 0))


def test_a_region_that_is_not_for_code_is_not_executed(chip):
    # bx r1
    program = at(Program(chip, "0847", handlers(MEMORY)), GUARD | 1)
    protect(chip, GUARD, FULL | NOT_EXECUTED)
    assert program.run().log() == [MEMORY - 16]
    assert chip.core.system.load(CFSR, 4) == IACCVIOL


def test_a_stack_that_meets_a_guard_is_a_hard_fault_in_which_the_guard_is_void(chip):
    program = at(Program(chip, PEND + WAIT, [(HARD_FAULT - 16, 0, LOAD + NOTE + LOOP), (LOW, 0x80, NOTE + RETURN)], pends=BIT[LOW]), GUARD)
    protect(chip, GUARD, NONE)
    chip.core.uc.reg_write(UC_ARM_REG_SP, GUARD + 0x410)
    assert program.run().log() == [HARD_FAULT - 16]
    assert chip.core.system.load(CFSR, 4) == MSTKERR


def test_the_higher_region_goes_before(chip):
    program = at(Program(chip, STORE + NOTE, handlers(MEMORY)), GUARD)
    protect(chip, GUARD, NONE)
    protect(chip, GUARD, FULL, number=1)
    assert program.run().log() == [-16]


def test_another_chip_knows_nothing_of_a_guard(chip, image):
    protect(chip, GUARD, NONE)
    twin, engine = chip.copy(), chip.engine
    chip.leave()
    other = Chip(image)
    assert other.engine is engine
    assert at(Program(other, STORE + NOTE, handlers(MEMORY)), GUARD).run().log() == [-16]
    assert at(Program(twin, STORE + NOTE, handlers(MEMORY)), GUARD).run().log() == [MEMORY - 16]
    # The engine of the first one is left with the fixture.
    twin.leave()


FORBIDDEN = [
    ("a map without its background", MPU_CTRL, 1, "PRIVDEFENA"),
    ("a region of 32 bytes", MPU_RASR, 4 << 1 | 1, "of 32 bytes"),
    ("parts of a region", MPU_RASR, 1 << 8 | 9 << 1 | 1, "of parts"),
    ("a deep sleep", SCR, 4, "SCR"),
    ("a priority in groups", AIRCR, 0x05FA_0300, "AIRCR"),
    ("a cycle counter without its clock", DWT_CTRL, 1, "DWT_CTRL"),
]


@pytest.mark.parametrize(("offset", "value", "told"), [entry[1:] for entry in FORBIDDEN], ids=[entry[0] for entry in FORBIDDEN])
def test_what_is_not_modelled_is_told(chip, offset, value, told):
    system = chip.core.system
    if offset == MPU_RASR:
        system.store(MPU_CTRL, 4, 5)
    system.store(offset, 4, value)
    with pytest.raises(Breach, match=told):
        chip.check()


def test_the_cycle_counter_counts_clocks(chip):
    program, system = Program(chip, WAIT), chip.core.system
    system.store(DEMCR, 4, 1 << 24)
    system.store(DWT_CTRL, 4, 1)
    begin = chip.time
    program.run(3_000)
    assert system.load(DWT_CYCCNT, 4) == chip.time - begin
    system.store(DWT_CTRL, 4, 0)
    stood = system.load(DWT_CYCCNT, 4)
    program.run(3_000)
    assert system.load(DWT_CYCCNT, 4) == stood
    chip.check()


def test_pendsv_comes_by_its_bit(chip):
    program = Program(chip, "", [(PENDSV - 16, 0, NOTE + RETURN)])
    program.run(100)
    chip.core.system.store(ICSR, 4, 1 << 28)
    assert program.run().log() == [PENDSV - 16]


def test_the_core_sleeps_behind_its_last_handler_if_it_is_to(chip):
    program = Program(chip, "", [(LOW, 0x80, NOTE + RETURN)])
    chip.core.system.store(SCR, 4, 2)
    program.run(100)
    chip.core.pend(16 + LOW)
    assert program.run().log() == [LOW]
    assert chip.core.sleeping


def test_a_program_can_reset_the_chip(chip):
    program = at(Program(chip, STORE), 0xE000_0000 + AIRCR)
    chip.core.uc.reg_write(UC_ARM_REG_R0, 0x05FA_0004)
    program.run(500)
    assert [reset.why for reset in chip.resets] == ["software"]
