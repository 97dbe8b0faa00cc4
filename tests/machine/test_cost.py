"""The model of cost: what instructions and exceptions take, by short programs."""

import pytest
from program import BIT, FLOAT, LOW, MAIN, NOTE, PEND, R7, RETURN, WAIT, WFI, Program
from stm32f405 import Chip
from stm32f405.engine import CCM, RAM


@pytest.fixture
def chip(image):
    chip = Chip(image)
    yield chip
    chip.leave()


def clocks(chip, code):
    """What instructions take, one behind the other."""
    Program(chip, code)
    extras, *_ = chip.core.count_cost().decode(MAIN, len(bytes.fromhex(code)))
    return len(extras) + sum(extras)


NOP = "00bf"
#: vldr s0, [pc] and ldr r0, [pc].
CONSTANTS = ("9fed000a", "0048")
ADD, MULTIPLY, COMPARE = "31ee810a", "21ee810a", "b4ee410a"
DIVIDE, ROOT = "81ee010a", "b1eee10a"
#: vmul s2, s0, s1; and vadd s4, s3, s3, which has nothing to do with s0.
USED, APART = "20ee201a", "31eea12a"
NOTHING_ELSE = [
    ("vadd.f32 s0, s3, s2", ADD, 1), ("vmul.f32 s0, s3, s2", MULTIPLY, 1), ("vneg.f32 s0, s2", "b1ee410a", 1), ("vcmp.f32 s0, s2", COMPARE, 1),
    ("vmrs", "f1ee10fa", 1), ("vmov s0, r0", FLOAT, 1), ("vmov r0, s0", "10ee100a", 1), ("vmov.f32 s0, #1", "b7ee000a", 1),
    ("vcvt.f32.s32 s0, s0", "b8eec00a", 1), ("vmla.f32 s0, s3, s2", "01ee810a", 3), ("vmls.f32 s0, s3, s2", "01eec10a", 3),
    ("vnmla.f32 s0, s3, s2", "11eec10a", 3), ("vfma.f32 s0, s3, s2", "a1ee810a", 3), ("vfnma.f32 s0, s3, s2", "91eec10a", 3),
    ("vdiv.f32 s0, s2, s2", DIVIDE, 14), ("vsqrt.f32 s0, s3", ROOT, 14), ("vldr s0, [sp]", "9ded000a", 2), ("vstr s0, [sp]", "8ded000a", 2),
    ("vpush {s0-s3}", "2ded040a", 5), ("vldmia sp, {s0-s7}", "9dec080a", 9), ("vmov r0, r1, s0, s1", "51ec100a", 2),
]  # fmt: skip


@pytest.mark.parametrize(("code", "takes"), [entry[1:] for entry in NOTHING_ELSE], ids=[entry[0] for entry in NOTHING_ELSE])
def test_an_instruction_of_the_fpu_takes_what_its_manual_says(chip, code, takes):
    assert clocks(chip, code) == takes


@pytest.mark.parametrize(
    ("code", "more"),
    [(ADD + USED, 1), (ADD + APART, 0), (ADD + NOP + USED, 0), (ADD + "9ded001a", 0), (ADD + "8ded000a", 1), ("b0ee410a" + USED, 0), (ADD + "02ee220a", 0)],
    ids=["computed with", "another one is", "an instruction later", "another one is loaded", "stored", "of a move", "added to"],
)
def test_a_result_of_the_fpu_that_is_used_at_once_takes_one_clock_more(chip, code, more):
    first, between, last = code[:8], code[8:-8], code[-8:]
    assert clocks(chip, code) == clocks(chip, first) + len(between) // 4 + clocks(chip, last) + more


@pytest.mark.parametrize("between", [0, 4, 20])
def test_a_division_goes_on_beside_instructions_of_the_core(chip, between):
    """The next one of the FPU waits for what is left of it."""
    assert clocks(chip, DIVIDE + between * NOP + APART) == max(14, 1 + between) + 1


@pytest.mark.parametrize(
    ("code", "low", "high"),
    [("aff30080", 0, 1), ("0868", 0, 1), ("9ded000a", 1, 1), ("009c", 1, 1), ("0fb4", 4, 1), ("bde8f003", 6, 1), ("9fed000a", 1, 1), ("0048", 1, 1)],
    ids=["nop.w", "ldr r0, [r1]", "vldr s0, [sp]", "ldr r4, [sp]", "push {r0-r3}", "pop.w {r4-r9}", "a constant", "ldr r0, a constant"],
)
def test_in_ram_an_instruction_takes_turns_with_a_stack_there_and_its_constants(chip, code, low, high):
    """Where the RAM is mapped to 0. At its own address each instruction waits for a clock."""
    elsewhere = clocks(chip, code)
    chip.engine.map_low(True)
    cost, size = chip.core.count_cost(), len(bytes.fromhex(code))
    chip.core.uc.mem_write(RAM + 0x1000, bytes.fromhex(code))

    def more(address):
        extras, _, lines = cost.decode(address, size)
        assert not lines
        return 1 + sum(extras) - elsewhere

    chip.core.top = RAM + 0x8000
    assert (more(0x1000), more(RAM + 0x1000)) == (low, high)
    # A stack in the core-coupled memory has nothing to do with it.
    chip.core.top = CCM + 0x8000
    assert more(0x1000) == (low if code in CONSTANTS else 0)


def test_a_constant_that_is_loaded_on_a_condition_changes_nothing_behind_it(chip):
    """mov.w r6, #0x08000000; movs r0, #1; cmp r0, #0; itt ne; ldrhne r1, [r6, #8]; andsne r1, r1, #0; beq; nop; movs r7, #5: that is on no condition."""
    program = Program(chip, "4ff00066 0120 0028 1cbf 3189 11f00001 00d0 00bf 0527" + WFI)
    chip.core.count_cost()
    chip.core.uc.reg_write(R7, 0)
    program.run()
    assert chip.core.uc.reg_read(R7) == 5


def test_an_instruction_is_counted_once_wherever_a_slice_ends(chip):
    """A slice has 100 of them at most, and a block may have more."""
    loads = 300
    program = Program(chip, loads * "9ded000a" + WFI)
    core = chip.core
    core.count_cost()
    program.run()
    assert core.sleeping
    # A branch to the first line, which is waited for, and the others are there in time.
    lines = 4 * loads // 16 + 1
    assert core.shares.clocks[256] == 2 + 5 + (lines - 1) + 2 * loads + 1


@pytest.mark.parametrize(
    ("before", "handler", "takes"),
    [("", "", 0), ("", FLOAT, 0), (FLOAT, "", 0), (FLOAT, FLOAT, 17 + 17)],
    ids=["neither", "the handler alone", "who was there alone", "both"],
)
def test_registers_of_the_fpu_are_stacked_where_both_use_it(chip, before, handler, takes):
    """A clock for each of the 17, and another to take it back. Entry and way back have 12 each, and so much is seen of all this."""
    program = Program(chip, before + PEND + WAIT, [(LOW, 0x80, NOTE + handler + RETURN)], pends=BIT[LOW])
    core = chip.core
    core.count_cost()
    assert program.run().log() == [LOW]
    # Its instructions, the branch to them and the wait for their line.
    instructions = 4 + len(handler) // 8 + 2 + 5
    served = core.shares.clocks[0x80]
    assert served == 12 + instructions + takes + 12
    assert core.cost.runs[16 + LOW] == served
