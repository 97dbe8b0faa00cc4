"""This model of TIM1, its DMA stream and TIM2, and the fast one of the crate `machine`, which has made `registers.txt`: the same writes to registers make
the same pulses (`machine/tests/two_models.rs`)."""

import pathlib

from stm32f405 import Chip

FILE = pathlib.Path(__file__).parent / "registers.txt"

TIM1, TIM2, DMA2, RCC, GPIOB = 0x1_0000, 0, 0x2_6400, 0x2_3800, 0x2_0400
#: Where the stream reads.
RING, WORDS = 0x2000_1000, 5

OFFSETS = dict(
    Cr1=0x00, Cr2=0x04, Smcr=0x08, Dier=0x0C, Sr=0x10, Egr=0x14, Ccmr1=0x18, Ccmr2=0x1C, Ccer=0x20, Cnt=0x24, Psc=0x28, Arr=0x2C, Rcr=0x30, Ccr1=0x34,
    Ccr2=0x38, Ccr4=0x40, Bdtr=0x44, Dcr=0x48,
)  # fmt: skip
STREAM = dict(Cr=0x88, Ndtr=0x8C, Par=0x90, M0ar=0x94, Fcr=0x9C, Flags=0x0C)


def address(register):
    if register.startswith("Stream"):
        return DMA2 + STREAM[register.removeprefix("Stream")]
    if register.startswith("Counter"):
        return TIM2 + OFFSETS[register.removeprefix("Counter")]
    return TIM1 + OFFSETS[register]


def set_up(chip):
    """Clocks for what is played, and the pins of the pulses."""
    for offset, bits in ((0x30, 1 << 1 | 1 << 22), (0x40, 1), (0x44, 1)):
        chip.store(RCC + offset, 4, chip.load(RCC + offset, 4) | bits)
    chip.store(GPIOB + 0x24, 4, 0x0111_0000)
    chip.store(GPIOB, 4, chip.load(GPIOB, 4) & ~(0x3F << 24) | 0x2A << 24)
    for pin, level in (("PB12", 1), ("PA0", 0), ("PA1", 0), ("PB11", 0)):
        chip.pins.drive(pin, level)


def test_a_stream_with_a_fifo_reads_four_words_ahead(image):
    """The other way that the stream can have, which the drive has not: what is written too late for it is played a round later."""
    chip = Chip(image)
    set_up(chip)
    chip.core.is_stopped = True
    stream, words = chip.dma2, list(range(100, 110))

    def write(number, word):
        chip.core.uc.mem_write(RING + 4 * number, word.to_bytes(4, "little"))

    for number, word in enumerate(words):
        write(number, word)
    chip.store(TIM1 + OFFSETS["Dcr"], 4, 0x040B)
    for register, value in (("Ndtr", 10), ("M0ar", RING), ("Par", 0x4001_004C), ("Fcr", 0x05), ("Cr", 6 << 25 | 0x5540)):
        chip.store(DMA2 + STREAM[register], 4, value)
    assert chip.load(DMA2 + STREAM["Fcr"], 4) >> 3 == 4
    chip.store(DMA2 + STREAM["Cr"], 4, chip.load(DMA2 + STREAM["Cr"], 4) | 1)
    assert chip.load(DMA2 + STREAM["Fcr"], 4) >> 3 == 5
    write(3, 203)
    write(4, 204)
    stream.burst()
    played = [chip.load(TIM1 + OFFSETS[name], 4) for name in ("Arr", "Rcr", "Ccr1", "Ccr2")]
    # ARR, RCR, CCR1, CCR2, CCR3: the fourth was there already, the fifth was not.
    assert played == [100, 101, 102, 103]
    assert chip.tim1["CCR3"] == 204
    assert chip.load(DMA2 + STREAM["Ndtr"], 4) == 5
    chip.check()
    chip.leave()


def run_to(chip, time):
    while (due := chip.tim1.next_event()) <= time:
        chip.time = due
        chip.tim1.event()
    chip.time = time
    chip.tim1.settle(time)


def test_the_same_writes_make_the_same_pulses(image):
    chip, expected, count = Chip(image), [], 0
    set_up(chip)
    # Nobody waits for the core on the buses.
    chip.core.is_stopped = True
    seen = []
    # What leaves the pin, as it is counted: a run may be cut in its middle.
    settle, tim1 = chip.tim1.settle, chip.tim1

    def watched(now):
        run, before = tim1.run, tim1.counted
        pulses = tim1.pulses
        settle(now)
        if tim1.pulses > pulses:
            seen.extend((run.begin + i * run.period, 1 if run.forward else -1) for i in range(before, tim1.counted))

    tim1.settle = watched
    for line in FILE.read_text().splitlines():
        time, kind, *words = line.split()
        if kind == "P":
            expected.append((int(time), int(words[0])))
            continue
        run_to(chip, int(time))
        if kind == "M":
            slot, *words = map(int, words)
            chip.core.uc.mem_write(RING + 4 * WORDS * slot, b"".join(word.to_bytes(4, "little") for word in words))
        elif kind == "R":
            tim1.reset()
        else:
            register, value = words
            chip.store(address(register), 4, RING if value == "ring" else int(value))
            count += 1
        chip.check()
    run_to(chip, chip.time + 168_000)
    assert count > 50 and len(expected) > 2_000
    assert seen == expected
    assert tim1.late_bursts == 0
    assert chip.tim2["CNT"] == len(expected)
