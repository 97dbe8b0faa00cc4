"""The model itself, where the image does not use all of it: registers are written as a program would."""

import pytest
from drive import ENABLE, PROFILE_POSITION
from stm32f405 import Breach, Chip

RCC, GPIOA, TIM3 = 0x2_3800, 0x2_0000, 0x400
CR1, SMCR, CCMR1, CCER, CNT, ARR = 0x00, 0x08, 0x18, 0x20, 0x24, 0x2C

#: One turn of an encoder through its four states, line A first.
FORWARDS = ((1, 0), (1, 1), (0, 1), (0, 0))


@pytest.fixture
def chip(image):
    return Chip(image)


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


@pytest.mark.parametrize(
    ("what", "address", "size", "value"),
    [
        ("an access to the MPU", 0xE000_ED94, 4, 5),
        ("a USART", 0x4000_4400, 4, 1),
        ("an SPI", 0x4001_3000, 4, 1),
        ("an encoder without inputs", 0x4000_0400 + CCMR1, 4, 0x0202),
        ("a timer that counts downwards", 0x4000_0400 + CR1, 4, 0x11),
        ("a byte in a peripheral that takes words", 0x4000_6400, 1, 1),
        ("a peripheral without its clock", 0x4000_0C00, 4, 1),
    ],
    ids=lambda value: value if isinstance(value, str) else "",
)
def test_what_is_forbidden_or_not_modelled_is_told(chip, what, address, size, value):
    chip.store(RCC + 0x40, 4, 1 << 25 | 2)
    if address >= 0xE000_0000:
        chip.core.system.store(address - 0xE000_0000, size, value)
    else:
        chip.store(address - 0x4000_0000, size, value)
    with pytest.raises(Breach):
        chip.check()


def test_a_frame_has_the_bit_time_in_which_it_began(bench):
    can, seen = bench.chip.can, []
    # The device sends nothing of its own meanwhile.
    real = can.end_received
    can.end_received = lambda frame: (seen.append((can.began, real(frame), can.fifo[-1][1] >> 16)))
    for _ in range(3):
        bench.network.send_message(0x123, b"\1\2")
    bench.milliseconds(2)
    assert len(seen) == 3
    for began, _, stamp in seen:
        # 1 Mbit/s.
        assert stamp == began // 168 % 0x10000


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
