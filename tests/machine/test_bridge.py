"""TIM1 as it drives three half bridges, and the converters that it starts: registers are written as a program would."""

import pytest
from stm32f405 import US, Breach, Chip
from stm32f405.interrupts import IRQ

RCC, GPIOA, GPIOB, GPIOC, TIM1, ADC1, ADC2, ADC_COMMON = 0x2_3800, 0x2_0000, 0x2_0400, 0x2_0800, 0x1_0000, 0x1_2000, 0x1_2100, 0x1_2304
CR1, CR2, DIER, SR, EGR, CCMR1, CCMR2, CCER, CNT, ARR, RCR, CCR1, CCR2, CCR3, CCR4, BDTR = (
    0x00, 0x04, 0x0C, 0x10, 0x14, 0x18, 0x1C, 0x20, 0x24, 0x2C, 0x30, 0x34, 0x38, 0x3C, 0x40, 0x44,
)  # fmt: skip
ADC_SR, ADC_CR1, ADC_CR2, SMPR1, SQR3, JSQR, JDR1, JDR2, ADC_DR = 0x00, 0x04, 0x08, 0x0C, 0x34, 0x38, 0x3C, 0x40, 0x4C

#: 24 kHz from 168 MHz, up and down.
HALF = 3_500
#: Half a microsecond of dead time: 84 clocks.
DEAD = 84
PINS = ("PA8", "PA9", "PA10", "PB13", "PB14", "PB15")


@pytest.fixture
def chip(image):
    chip = Chip(image)
    # Time passes, and nobody but the test writes.
    chip.core.is_stopped = True
    chip.store(RCC + 0x30, 4, chip.load(RCC + 0x30, 4) | 7)
    chip.store(RCC + 0x44, 4, 3 << 8 | 1)
    yield chip
    chip.leave()


def bridge(chip, compares=(1_000, 1_750, 2_500), trigger=3_400, repeat=1, other={}, uppers=3):
    """Three half bridges, and the fourth channel whose signal rises shortly before the top."""
    chip.store(GPIOA + 0x24, 4, 0x1111 >> 4 * (4 - uppers))
    chip.store(GPIOA, 4, chip.load(GPIOA, 4) | 0xAA_0000 & (1 << 16 + 2 * uppers) - 1)
    chip.store(GPIOB + 0x24, 4, 0x1110_0000)
    chip.store(GPIOB, 4, chip.load(GPIOB, 4) | 0xA800_0000)
    values = {
        CR2: 7 << 4, CCMR1: 0x6868, CCMR2: 0x7868, CCER: 0x1555, ARR: HALF, RCR: repeat, CCR1: compares[0], CCR2: compares[1], CCR3: compares[2],
        CCR4: trigger, BDTR: 1 << 15 | 1 << 11 | 1 << 10 | DEAD, EGR: 1, SR: 0, CR1: 1 << 7 | 1 << 5 | 1,
    }  # fmt: skip
    for register, value in (values | other).items():
        chip.store(TIM1 + register, 4, value)


def converters(chip):
    """Two of them, each with a current, at a rise of the fourth channel."""
    chip.store(GPIOC, 4, 0xFF)
    chip.store(ADC_COMMON, 4, 1 << 16)
    for adc, channel in ((ADC1, 0), (ADC2, 1)):
        chip.store(adc + SMPR1, 4, 0)
        chip.store(adc + JSQR, 4, 10 + channel << 15)
        chip.store(adc + ADC_CR1, 4, 1 << 7)
        chip.store(adc + ADC_CR2, 4, 1 << 20 | 1 << 16 | 1)
    chip.run(3 * US)


def edges(chip, pin, clocks):
    """The moments in which a pin changes, and what it has then."""
    levels, begin, before = [], chip.time, None
    for _ in range(clocks):
        level = chip.tim1.centre.level(pin)
        if level != before:
            levels.append((chip.time - begin, level))
            before = level
        chip.run(1)
    return levels


def test_the_counter_goes_up_and_down_and_tells_which(chip):
    bridge(chip)
    seen = []
    for _ in range(8):
        seen.append((chip.load(TIM1 + CNT, 4), chip.load(TIM1 + CR1, 4) >> 4 & 1))
        chip.run(HALF // 2)
    half = HALF // 2
    assert seen == [(0, 0), (half, 0), (HALF, 1), (half, 1)] * 2
    chip.check()


def test_the_two_transistors_of_a_half_bridge_have_the_dead_time_between_them(chip):
    bridge(chip)
    upper, lower = edges(chip, "PA8", 2 * HALF), edges(chip, "PB13", 2 * HALF + 1_000 + DEAD)
    # On around the moment in which the counter is 0; a rise waits for the dead time.
    assert upper == [(0, 1), (1_000, 0), (2 * HALF - 1_000 + DEAD, 1)]
    # Seen from the next period on.
    assert lower == [(0, 0), (1_000 + DEAD, 1), (2 * HALF - 1_000, 0), (2 * HALF + 1_000 + DEAD, 1)][:len(lower)]
    assert len(lower) >= 3
    chip.check()


@pytest.mark.parametrize(("code", "clocks"), [(0x7F, 127), (0x80, 128), (0xBF, 254), (0xC0, 256), (0xDF, 504), (0xE0, 512), (0xFF, 1_008)])
def test_the_code_of_a_dead_time(chip, code, clocks):
    bridge(chip)
    chip.tim1["BDTR"] = code
    assert chip.tim1.centre.dead_time() == clocks


@pytest.mark.parametrize(("compare", "upper", "lower"), [(0, 0, 1), (HALF, 1, 0)])
def test_none_and_all_of_a_period_have_no_edge(chip, compare, upper, lower):
    bridge(chip, compares=(compare,) * 3)
    assert (edges(chip, "PA9", 2 * HALF), edges(chip, "PB14", 2 * HALF)) == ([(0, upper)], [(0, lower)])


@pytest.mark.parametrize("at_top", [False, True])
def test_what_is_written_acts_at_the_next_update_event(chip, at_top):
    chip.tim1.centre.odd_updates_at_top = at_top
    bridge(chip)
    chip.store(TIM1 + CCR1, 4, 2_000)
    centre, begin = chip.tim1.centre, chip.time
    assert centre.duties() == (1_000 / HALF, 1_750 / HALF, 2_500 / HALF)
    chip.run(6 * HALF)
    first = HALF if at_top else 2 * HALF
    # An event for each period: RCR is 1.
    assert [(update.time - begin, update.at_top) for update in centre.log] == [(first + 2 * HALF * i, at_top) for i in range(3)]
    assert centre.duties()[0] == 2_000 / HALF
    assert chip.load(TIM1 + SR, 4) & 1
    chip.check()


def test_the_outputs_go_off_by_one_bit_and_by_the_break(chip):
    changes = []
    chip.tim1.centre.on_change = lambda: changes.append(chip.tim1.centre.duties() is not None)
    bridge(chip)
    chip.run(10 * HALF)
    chip.store(TIM1 + BDTR, 4, 1 << 11 | 1 << 10 | DEAD)
    assert [chip.tim1.centre.level(pin) for pin in PINS] == [0] * 6
    assert changes[-2:] == [True, False]
    chip.store(TIM1 + BDTR, 4, 1 << 11 | DEAD)
    assert [chip.tim1.centre.level(pin) for pin in PINS] == [None] * 6
    # A break at PB12, low active.
    chip.store(GPIOB + 0x24, 4, 0x1111_0000)
    chip.store(GPIOB, 4, chip.load(GPIOB, 4) | 0x200_0000)
    chip.pins.drive("PB12", 1)
    chip.store(TIM1 + BDTR, 4, 1 << 15 | 1 << 12 | 1 << 10 | DEAD)
    assert chip.tim1.centre.duties() is not None
    chip.pins.drive("PB12", 0)
    assert chip.tim1.centre.duties() is None
    chip.check()


def test_both_converters_sample_at_the_rise_of_the_fourth_channel(chip):
    chip.adc.levels[10] = chip.adc.levels[11] = lambda at: at & 0xFFF
    converters(chip)
    bridge(chip)
    begin, asked = chip.time, []
    for _ in range(4 * HALF):
        chip.run(1)
        if chip.adc.lines():
            asked.append(chip.time - begin)
            results = [chip.load(adc + JDR1, 4) for adc in (ADC1, ADC2)]
            # Three clocks of 21 MHz behind the rise they hold what they have, and 12 later they are done.
            held = chip.time - 12 * 8
            assert results == [held & 0xFFF] * 2
            for adc in (ADC1, ADC2):
                chip.store(adc + ADC_SR, 4, 0)
    # Mode 2: active from the compare value on, up, so it rises there.
    assert asked == [3_400 + 15 * 8, 2 * HALF + 3_400 + 15 * 8]
    assert IRQ["ADC"] == 18
    chip.check()


def test_an_update_event_starts_them_as_well(chip):
    converters(chip)
    bridge(chip, other={CR2: 2 << 4})
    chip.run(2 * HALF + 15 * 8 - 1)
    assert not chip.adc.lines()
    chip.run(1)
    assert chip.adc.lines() == (IRQ["ADC"],)
    chip.check()


def four_inputs(chip, other={}):
    """The four channels at the inputs of a driver, without complements and dead time; each update event starts the converters."""
    values = {CR2: 2 << 4, CCMR2: 0x6868, CCER: 0x1111, BDTR: 1 << 15 | 1 << 11 | 1 << 10, CCR4: 3_000, RCR: 0}
    bridge(chip, other=values | other, uppers=4)


def test_four_half_bridges_whose_converters_start_at_both_ends(chip):
    converters(chip)
    four_inputs(chip)
    assert chip.tim1.centre.duties() == (1_000 / HALF, 1_750 / HALF, 2_500 / HALF, 3_000 / HALF)
    assert edges(chip, "PA11", 2 * HALF) == [(0, 1), (3_000, 0), (2 * HALF - 3_000, 1)]
    for adc in (ADC1, ADC2):
        chip.store(adc + ADC_SR, 4, 0)
    begin, asked = chip.time, []
    for _ in range(2 * HALF + 200):
        chip.run(1)
        if chip.adc.lines():
            asked.append((chip.time - begin, chip.load(TIM1 + CR1, 4) >> 4 & 1))
            for adc in (ADC1, ADC2):
                chip.store(adc + ADC_SR, 4, 0)
    # Behind the bottom, which was a moment ago, behind the top, where it counts down, and so on.
    assert asked == [(120, 0), (HALF + 120, 1), (2 * HALF + 120, 0)]
    chip.store(TIM1 + BDTR, 4, 1 << 11 | 1 << 10)
    assert chip.tim1.centre.duties() is None and chip.tim1.centre.level("PA11") == 0
    chip.check()


def test_a_fourth_half_bridge_without_its_pin_is_told(chip):
    four_inputs(chip)
    chip.store(GPIOA, 4, chip.load(GPIOA, 4) & ~0xC0_0000)
    chip.store(TIM1 + CCER, 4, 0x1111)
    with pytest.raises(Breach, match="output 4 is on and has not one pin"):
        chip.check()


def test_a_regular_conversion_makes_way_for_the_injected_group_and_begins_anew(chip):
    chip.adc.levels |= {10: 100, 11: 200, 13: 300}
    converters(chip)
    for register, value in ((SQR3, 13), (JSQR, 1 << 20 | 11 << 15 | 10 << 10), (ADC_CR1, 1 << 8 | 1 << 7)):
        chip.store(ADC1 + register, 4, value)
    chip.store(ADC1 + ADC_CR2, 4, chip.load(ADC1 + ADC_CR2, 4) | 1 << 30)
    chip.run(60)
    chip.store(ADC1 + ADC_CR2, 4, chip.load(ADC1 + ADC_CR2, 4) | 1 << 22)
    chip.run(2 * 15 * 8)
    assert chip.load(ADC1 + ADC_SR, 4) & 6 == 4
    assert (chip.load(ADC1 + JDR1, 4), chip.load(ADC1 + JDR2, 4)) == (100, 200)
    chip.run(15 * 8)
    assert chip.load(ADC1 + ADC_SR, 4) & 2
    assert chip.load(ADC1 + ADC_DR, 4) == 300
    chip.check()


def test_the_analog_watchdog_tells_what_is_out_of_its_window(chip):
    converters(chip)
    chip.adc.levels[10] = 2_000
    for offset, value in ((0x24, 3_000), (0x28, 1_000), (ADC_CR1, 1 << 22 | 1 << 6)):
        chip.store(ADC1 + offset, 4, value)
    for level, told in ((2_000, ()), (3_001, (IRQ["ADC"],)), (999, (IRQ["ADC"],))):
        chip.adc.levels[10] = level
        chip.store(ADC1 + ADC_CR2, 4, 1 << 22 | 1)
        chip.run(15 * 8)
        assert chip.adc.lines() == told
        chip.store(ADC1 + ADC_SR, 4, 0)
    chip.check()


FORBIDDEN = [
    ("two transistors without dead time", {BDTR: 1 << 15}, "without dead time"),
    ("a channel without preload", {CCMR1: 0x6860}, "channel 1 .* preload"),
    ("an output without its pin", {CCER: 0x1555 & ~0x100, BDTR: 1 << 15 | DEAD}, None),
    ("a start without an update event", {EGR: 0}, "no update event has taken"),
]


@pytest.mark.parametrize(("other", "told"), [entry[1:] for entry in FORBIDDEN], ids=[entry[0] for entry in FORBIDDEN])
def test_what_a_bridge_must_not_have_is_told(chip, other, told):
    bridge(chip, other=other)
    if told is None:
        # One output of three phases less, and then its pin is the port's.
        chip.check()
        chip.store(GPIOB, 4, chip.load(GPIOB, 4) & ~0xC000_0000 | 0x4000_0000)
        chip.store(TIM1 + CCER, 4, 0x1555)
        told = "output 3N is on and has not one pin"
    with pytest.raises(Breach, match=told):
        chip.check()


def write(chip, register, value):
    chip.store(register, 4, value)


MISUSES = [
    ("a converter that is off", lambda chip: write(chip, ADC1 + ADC_CR2, 1 << 22), "off or not yet stable"),
    ("a pin that is none of the converter", lambda chip: (chip.store(GPIOC, 4, 0), write(chip, ADC1 + ADC_CR2, 1 << 22 | 1)), "PC0 is no analog pin"),
    ("a clock that is too fast", lambda chip: (write(chip, ADC_COMMON, 0), write(chip, ADC1 + ADC_CR2, 1 << 22 | 1)), "42000000 Hz"),
    ("a group without SCAN", lambda chip: (write(chip, ADC1 + JSQR, 1 << 20), write(chip, ADC1 + ADC_CR2, 1 << 22 | 1)), "without SCAN"),
    ("the trigger of another timer", lambda chip: write(chip, ADC1 + ADC_CR2, 1 << 20 | 3 << 16 | 1), "a trigger other than TIM1's"),
    ("the way it counts while it does", lambda chip: (bridge(chip), write(chip, TIM1 + CR1, 1 << 7 | 1)), "changes while it does"),
    ("another period while it counts", lambda chip: (bridge(chip), write(chip, TIM1 + ARR, 1_000), chip.run(2 * HALF)), "ARR changes"),
]


@pytest.mark.parametrize(("misuse", "told"), [entry[1:] for entry in MISUSES], ids=[entry[0] for entry in MISUSES])
def test_what_is_forbidden_is_told(chip, misuse, told):
    converters(chip)
    chip.check()
    with pytest.raises(Breach, match=told):
        misuse(chip)
        chip.check()
