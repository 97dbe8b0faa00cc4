"""The model itself, where the image does not use all of it: registers are written as a program would."""

import pytest
from drive import ENABLE, PROFILE_POSITION
from program import LOOP, NOTE, Program
from stm32f405 import MS, US, Breach, Chip
from stm32f405.bxcan import ABOM, BOFF, TTCM, Frame
from stm32f405.can_filters import match
from stm32f405.engine import CCM
from stm32f405.exti import LOW_RAM
from unicorn import UcError

RCC, GPIOA, DMA2, TIM3 = 0x2_3800, 0x2_0000, 0x2_6400, 0x400
CR1, SMCR, CCMR1, CCER, CNT, ARR = 0x00, 0x08, 0x18, 0x20, 0x24, 0x2C

#: One turn of an encoder through its four states, line A first.
FORWARDS = ((1, 0), (1, 1), (0, 1), (0, 0))


@pytest.fixture
def chip(image):
    chip = Chip(image)
    yield chip
    chip.leave()


def encoder(chip, mode, lines=0x0101):
    """TIM3 as a counter of an encoder at PA6 and PA7."""
    chip.store(RCC + 0x30, 4, chip.load(RCC + 0x30, 4) | 1)
    chip.store(RCC + 0x40, 4, chip.load(RCC + 0x40, 4) | 2)
    chip.store(GPIOA + 0x20, 4, 0x2200_0000)
    chip.store(GPIOA, 4, chip.load(GPIOA, 4) | 0xA000)
    for pin in ("PA6", "PA7"):
        chip.pins.drive(pin, 0)
    for register, value in ((CCMR1, lines), (SMCR, mode), (ARR, 0xFFFF), (CR1, 1)):
        chip.store(TIM3 + register, 4, value)


def turn(chip, states, times):
    for _ in range(times):
        for a, b in states:
            chip.pins.drive("PA6", a)
            chip.pins.drive("PA7", b)


@pytest.mark.parametrize(("mode", "counts"), [(1, 2), (2, 2), (3, 4)])
def test_an_encoder_counts_its_edges_both_ways(chip, mode, counts):
    encoder(chip, mode)
    turn(chip, FORWARDS, 5)
    assert chip.load(TIM3 + CNT, 4) == 5 * counts
    backwards = (FORWARDS[2], FORWARDS[1], FORWARDS[0], FORWARDS[3])
    turn(chip, backwards, 6)
    assert chip.load(TIM3 + CNT, 4) == 0x10000 - counts
    chip.check()


def test_a_line_that_rattles_counts_nothing_in_the_end(chip):
    encoder(chip, 3)
    turn(chip, ((1, 0), (0, 0)), 100)
    assert chip.load(TIM3 + CNT, 4) == 0


def test_a_line_inverted_turns_the_way_round(chip):
    encoder(chip, 3)
    chip.store(TIM3 + CCER, 4, 2)
    turn(chip, FORWARDS, 1)
    assert chip.load(TIM3 + CNT, 4) == 0xFFFC


#: What is written where, behind 4000_0000h or in the core, and what is told of it.
FORBIDDEN = [
    ("the trace of the core", 0xE000_0E00, 4, 1, "core register"),
    ("half a word in the controller of interrupts", 0xE000_E100, 2, 1, "2 bytes"),
    ("a priority of five bits", 0xE000_E400, 1, 0x18, "upper four bits"),
    ("a serial line of nine bits", 0x4000_440C, 4, 1 << 12, "CR1 .* 0x1000 do"),
    ("an SPI as a slave", 0x4001_3000, 4, 1 << 6, "another use than a master"),
    ("the clock of an I2C", 0x4002_3840, 4, 1 << 21 | 1 << 25 | 2, "APB1ENR .* 0x200000 do"),
    ("a PLL before its crystal", 0x4002_3800, 4, 0x0101_0083, "before its crystal is ready"),
    ("a clock that is not ready", 0x4002_3808, 4, 2, "not ready"),
    ("an encoder without inputs", 0x4000_0400 + CCMR1, 4, 0x0202, "CCMR1"),
    ("a timer that counts downwards", 0x4000_0400 + CR1, 4, 0x11, "CR1 .* 0x10 do"),
    ("a reserved bit", 0x4000_0400 + CR1, 4, 0x401, "reserved bits 0x400"),
    ("outputs of TIM1 that come back of themselves", 0x4001_0044, 4, 1 << 14, "BDTR .* 0x4000 do"),
    ("a byte in a peripheral that takes words", 0x4000_6400, 1, 1, "1 bytes"),
    ("a FIFO that keeps its oldest frames", 0x4000_6400, 4, 0x1_0009, "MCR .* 0x8 do"),
    ("a filter of CAN 2", 0x4000_6604, 4, 1 << 14, "FM1R .* 0x4000 do"),
    ("a bit time outside of initialisation", 0x4000_641C, 4, 0x011A_0002, "outside of initialisation"),
    ("a peripheral without its clock", 0x4000_0C00, 4, 1, "without the clock"),
    ("a watchdog's register without access", 0x4000_3008, 2, 100, "without access"),
    ("flash that is locked", 0x4002_3C10, 4, 1, "locked"),
    ("a conversion again and again", 0x4001_2008, 4, 2, "CR2 .* 0x2 do"),
    ("injected conversions in parts", 0x4001_2004, 4, 1 << 12, "CR1 .* 0x1000 do"),
    ("two converters in turn", 0x4001_2304, 4, 6, "CCR .* 0x6 do"),
    ("an interrupt by a pin that floats", 0x4001_3C00, 4, 1 << 4, "PA4, which floats"),
    ("system memory at address 0", 0x4001_3800, 4, 1, "MEMRMP"),
    ("RAM where vectors are fetched from", 0x4001_3800, 4, 3, "vectors"),
    ("a stream in memory that it cannot reach", 0x4002_6488, 4, 6 << 25 | 2 << 13 | 2 << 11 | 1 << 10 | 1 << 8 | 1 << 6 | 1, "cannot reach"),
]


@pytest.mark.parametrize(("address", "size", "value", "told"), [entry[1:] for entry in FORBIDDEN], ids=[entry[0] for entry in FORBIDDEN])
def test_what_is_forbidden_or_not_modelled_is_told(chip, address, size, value, told):
    chip.store(RCC + 0x30, 4, chip.load(RCC + 0x30, 4) | 1 << 22 | 1)
    chip.store(RCC + 0x40, 4, 1 << 25 | 1 << 17 | 2)
    chip.store(RCC + 0x44, 4, 1 << 14 | 1 << 12 | 1 << 8 | 1)
    # The crystal as the source of the PLL.
    chip.store(RCC + 0x04, 4, 0x2740_5408)
    # The memory of the core alone.
    chip.store(DMA2 + 0x8C, 4, 10)
    chip.store(DMA2 + 0x94, 4, CCM)
    chip.check()
    if address >= 0xE000_0000:
        chip.core.store(address - 0xE000_0000, size, value)
    else:
        chip.store(address - 0x4000_0000, size, value)
    with pytest.raises(Breach, match=told):
        chip.check()


def test_flash_is_at_0_and_once_it_is_mapped_the_ram_until_a_reset(chip):
    read, flash = chip.core.uc.mem_read, chip.engine.flash[:64]
    assert read(0, 64) == flash
    program = Program(chip, "")
    chip.store(RCC + 0x44, 4, 1 << 14)
    chip.store(0x1_3800, 4, LOW_RAM)
    chip.check()
    # What is written at one of its addresses is fetched from the other.
    code = bytes.fromhex(NOTE + LOOP)
    chip.core.uc.mem_write(0x2000_1000, code)
    assert read(0x1000, len(code)) == code
    twin = chip.copy()
    chip.core.pc = 0x1001
    assert program.run().log() == [-16]
    assert chip.engine.ram[0x1_BFFC:0x1_C000] == read(0x1_BFFC, 4)
    with pytest.raises(UcError):
        read(0x1_C000, 4)
    chip.reset("of a test")
    assert read(0, 64) == flash
    assert twin.core.uc.mem_read(0x1000, len(code)) == code
    twin.leave()


def test_a_pin_that_floats_reads_as_anything(chip):
    chip.store(RCC + 0x30, 4, 0x0010_0001)
    # A pull-up at PA1, a pull-down at PA2; PA13 to PA15 have those of the debugger.
    chip.store(GPIOA + 0x0C, 4, 0x6400_0024)
    seen = [chip.load(GPIOA + 0x10, 4) for _ in range(50)]
    ones = [sum(levels >> pin & 1 for levels in seen) for pin in range(16)]
    assert (ones[1], ones[2]) == (50, 0)
    assert all(0 < ones[pin] < 50 for pin in (0, *range(3, 13)))
    chip.pins.drive("PA0", 1)
    assert chip.load(GPIOA + 0x10, 4) & 1
    chip.check()


def test_a_pin_that_two_drive_is_told(chip):
    chip.store(RCC + 0x30, 4, 0x0010_0001)
    chip.pins.drive("PA0", 1)
    chip.store(GPIOA, 4, 0xA800_0001)
    with pytest.raises(Breach, match="PA0 becomes an output"):
        chip.check()


@pytest.mark.parametrize("bit_timing", [0x0049_0002, 0x000E_0001, 0x031A_0002], ids=["69 %", "94 %", "jumps too far"])
def test_a_bit_that_is_sampled_out_of_place_is_told(bench, bit_timing):
    can = bench.chip.can
    can["MSR"] |= 1
    can.write_BTR(0x011A_0002)
    bench.chip.check()
    can.write_BTR(bit_timing)
    with pytest.raises(Breach, match="samples at"):
        bench.chip.check()


def test_a_filter_lets_its_identifiers_in(bench):
    can = bench.chip.can
    can["F0R1"], can["F0R2"] = 0x120 << 21, 0x7F0 << 21
    for identifier in (0x11F, 0x120, 0x12F, 0x130):
        can.to_send.append(Frame(identifier, False, False, b""))
    before = can.stats["received"]
    bench.milliseconds(1)
    assert can.stats["received"] - before == 2 and can.stats["filtered"] == 2


def short(identifier, mask=0):
    """Two halves of a filter of 16 bits: an identifier and a mask, or another one."""
    return identifier << 5 | mask << 21


#: Bank 1 and what it takes of the identifiers 120h to 127h: list, 32 bits, words. The words of masks want standard data frames.
BANKS = {
    "a mask of 32 bits": (0, 1, 0x124 << 21, 0x7FE << 21 | 6, {0x124: 0, 0x125: 0}),
    "a list of 32 bits": (1, 1, 0x122 << 21, 0x127 << 21, {0x122: 0, 0x127: 1}),
    "masks of 16 bits": (0, 0, short(0x120, 0x7FF) | 0x18 << 16, short(0x126, 0x7FE) | 0x18 << 16, {0x120: 0, 0x126: 1, 0x127: 1}),
    "a list of 16 bits": (1, 0, short(0x121, 0x122), short(0x123, 0x127), {0x121: 0, 0x122: 1, 0x123: 2, 0x127: 3}),
}


@pytest.mark.parametrize("fifo", [0, 1])
@pytest.mark.parametrize(("is_list", "is_wide", "first", "second", "taken"), BANKS.values(), ids=list(BANKS))
def test_a_bank_of_filters_says_which_of_them_took_a_frame(bench, is_list, is_wide, first, second, taken, fifo):
    chip, can = bench.chip, bench.chip.can
    for offset, value in ((0x200, 0x2A1C_0E01), (0x21C, 2), (0x204, is_list << 1), (0x20C, is_wide << 1), (0x214, fifo << 1)):
        chip.store(0x6400 + offset, 4, value)
    for offset, value in ((0x248, first), (0x24C, second), (0x200, 0x2A1C_0E00), (0x14, 0x10)):
        chip.store(0x6400 + offset, 4, value)
    seen = {}
    received = can.end_received

    def note(frame):
        before = can.stats["filtered"]
        received(frame)
        if can.stats["filtered"] == before:
            seen[frame.id] = chip.load(0x65B4 + 16 * fifo, 4) >> 8 & 0xFF
            chip.store(0x640C + 4 * fifo, 4, 1 << 5)

    can.end_received = note
    # With another length the frames of the device itself are not meant.
    for identifier in range(0x120, 0x128):
        can.to_send.append(Frame(identifier, False, False, b"1234567"))
    bench.milliseconds(2)
    # Bank 0 is off, and its two filters have numbers of FIFO 0 all the same.
    numbers = {identifier: number + (2 if fifo == 0 else 0) for identifier, number in taken.items()}
    assert seen == numbers
    chip.check()


def test_narrow_filters_come_behind_wide_ones_and_masks_behind_lists(bench):
    can = bench.chip.can
    word = 0x120 << 21
    can["FA1R"], can["FS1R"], can["FM1R"] = 0b1111, 0b1010, 0b1100
    # By bank: masks of 16 bits, a mask of 32, a list of 16, a list of 32.
    for bank, words in enumerate(((short(0x120, 0x7FF), 0), (word, 0x7FF << 21), (short(0x120), 0), (word, 0))):
        can[f"F{bank}R1"], can[f"F{bank}R2"] = words
    for bank, number in ((3, 7), (1, 2), (2, 3), (0, 0)):
        assert match(can, word) == (0, number)
        can["FA1R"] &= ~(1 << bank)
    assert match(can, word) is None


def test_with_txfp_frames_leave_in_the_order_of_their_requests(bench):
    chip, can = bench.chip, bench.chip.can
    sent = []
    can.on_frame = lambda frame: sent.append(frame.id)
    for in_order, expected in ((False, [0x100, 0x200, 0x300]), (True, [0x300, 0x100, 0x200])):
        sent.clear()
        chip.store(0x6400, 4, 0x1_0000 | (4 if in_order else 0))
        # The bus is taken meanwhile.
        can.to_send.append(Frame(0x7F, False, False, b"12345678"))
        chip.run(20 * US)
        for mailbox, identifier in enumerate((0x300, 0x100, 0x200)):
            chip.store(0x6580 + 16 * mailbox + 4, 4, 0)
            chip.store(0x6580 + 16 * mailbox, 4, identifier << 21 | 1)
        chip.run(MS)
        assert [identifier for identifier in sent if identifier in expected] == expected
    chip.check()


@pytest.mark.parametrize("counts", [True, False])
def test_a_frame_has_the_bit_time_in_which_it_began(bench, counts):
    can, seen = bench.chip.can, []
    if counts:
        can["MCR"] |= TTCM
    # The device sends nothing of its own meanwhile.
    real = can.end_received
    can.end_received = lambda frame: (seen.append((can.began, real(frame), can.fifos[0][-1][1] >> 16)))
    for _ in range(3):
        bench.network.send_message(0x123, b"\1\2")
    bench.milliseconds(2)
    assert len(seen) == 3
    for began, _, stamp in seen:
        # 1 Mbit/s.
        assert stamp == (began // 168 % 0x10000 if counts else 0)


def test_a_controller_may_come_back_from_bus_off_by_itself(bench):
    can, chip = bench.chip.can, bench.chip
    can["MCR"] |= ABOM
    # Nobody asks it to leave the bus meanwhile.
    can.lines = lambda: ()
    since = chip.time
    can.go_bus_off()
    assert chip.run(5 * MS, lambda: not can["ESR"] & BOFF)
    assert chip.time - since - 128 * 11 * can.bit() < 10 * US


def test_an_interrupt_that_nobody_clears_is_told(bench):
    # The handler of the timer clears its flag; here it comes back at once.
    bench.chip.tim3.write_SR = lambda value: None
    bench.chip.tim3.writers[0x10] = bench.chip.tim3.write_SR
    with pytest.raises(Breach, match="never cleared"):
        bench.milliseconds(50)


@pytest.mark.parametrize("ahead", [False, True])
def test_ndtr_may_count_what_is_fetched_or_what_is_written(drive, ahead):
    """The manual leaves open whether a stream in direct mode has fetched a word when NDTR is read before the first request. Either way the pulses are the
    same, and step and direction are never left to themselves: where TIM1 is reset, their pins are pulled down."""
    chip = drive.chip
    chip.dma2.fetches_ahead = ahead
    begin = chip.tim1.position
    drive[0x6081], drive[0x6083], drive[0x6084] = 100_000, 1_000_000, 1_000_000
    drive.enable(PROFILE_POSITION)
    for target in (1_500, -400):
        drive[0x607A] = target
        drive[0x6040] = ENABLE | 0x30
        drive[0x6040] = ENABLE
        drive.until(lambda: drive[0x6041] & 0x400 and drive[0x6064] == target, f"at {target}")
        assert drive.settle() - begin == target
    for pin in (13, 14):
        assert chip.gpio["B"]["PUPDR"] >> 2 * pin & 3 == 2
