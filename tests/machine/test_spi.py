"""SPI masters, and the gate driver on one: registers are written as a program would."""

import pytest
from gate_driver import CONTROL_1, FAULT, IDENTITY, READ, READY, STATUS_1, STATUS_2, GateDriver
from stm32f405 import MS, US, Breach, Chip
from stm32f405.interrupts import IRQ

RCC, GPIOB, GPIOC, SPI3 = 0x2_3800, 0x2_0400, 0x2_0800, 0x3C00
CR1, CR2, SR, DR = 0x00, 0x04, 0x08, 0x0C
RXNE, TXE, OVR, BSY = 1, 2, 1 << 6, 1 << 7
#: Sixteen bits, SSM and SSI, 42 MHz by 8, master, data at the second edge.
SETTINGS = 1 << 11 | 3 << 8 | 2 << 3 | 1 << 2 | 1
ON = 1 << 6
#: Clocks of a word: 16 bits of 5.25 MHz.
WORD = 16 * 32


@pytest.fixture
def chip(image):
    """A gate driver at PC10 to PC12, chosen by PC13, enabled by PB12; it pulls PD2 low in a fault."""
    chip = Chip(image)
    chip.core.is_stopped = True
    chip.store(RCC + 0x30, 4, chip.load(RCC + 0x30, 4) | 0xF)
    chip.store(RCC + 0x40, 4, 1 << 15)
    chip.store(GPIOC + 0x24, 4, 0x6_6600)
    chip.store(GPIOC + 0x18, 4, 1 << 13)
    chip.store(GPIOC, 4, 0x6A0_0000 & ~0xC00_0000 | 1 << 26)
    chip.store(GPIOB, 4, chip.load(GPIOB, 4) | 1 << 24)
    chip.driver = GateDriver(chip.spi[3], "PC13", "PB12", "PD2")
    yield chip
    chip.leave()


def begin(chip, settings=SETTINGS):
    chip.store(SPI3 + CR1, 4, settings)
    chip.store(SPI3 + CR1, 4, settings | ON)


def enable(chip, wait=READY):
    chip.store(GPIOB + 0x18, 4, 1 << 12)
    chip.run(wait)


def transfer(chip, *words):
    """A frame; what has come."""
    chip.store(GPIOC + 0x18, 4, 1 << 29)
    answers = []
    for word in words:
        chip.store(SPI3 + DR, 2, word)
        chip.run(WORD)
        answers.append(chip.load(SPI3 + DR, 2))
    chip.store(GPIOC + 0x18, 4, 1 << 13)
    return answers[-1]


def read(chip, register):
    transfer(chip, READ | register << 11)
    return transfer(chip, READ | register << 11) & 0x7FF


def test_a_word_takes_its_time_and_another_may_wait_behind_it(chip):
    begin(chip)
    for word in (1, 2):
        chip.store(SPI3 + DR, 2, word)
    assert chip.load(SPI3 + SR, 2) == BSY
    chip.run(WORD - 1)
    assert chip.load(SPI3 + SR, 2) == BSY
    chip.run(1)
    assert chip.load(SPI3 + SR, 2) == BSY | TXE | RXNE
    assert chip.load(SPI3 + DR, 2) == 0xFFFF
    chip.run(WORD)
    assert chip.load(SPI3 + SR, 2) == TXE | RXNE
    chip.check()


def test_a_word_that_nobody_takes_is_an_overrun_and_the_older_one_stays(chip):
    begin(chip)
    enable(chip)
    chip.store(GPIOC + 0x18, 4, 1 << 29)
    chip.driver.answer = 0x1234
    for _ in range(2):
        chip.store(SPI3 + DR, 2, 0)
        chip.run(WORD)
    # By DR and then SR, or by SR and then DR.
    assert chip.load(SPI3 + SR, 2) & (OVR | RXNE) == OVR | RXNE
    assert chip.load(SPI3 + DR, 2) == 0x1234
    assert chip.load(SPI3 + SR, 2) & (OVR | RXNE) == 0
    chip.check()


def test_its_interrupts_are_asked_for_one_by_one(chip):
    begin(chip)
    assert chip.spi[3].lines() == ()
    chip.store(SPI3 + CR2, 2, 1 << 7)
    assert chip.spi[3].lines() == (IRQ["SPI3"],)
    chip.store(SPI3 + CR2, 2, 1 << 6)
    assert chip.spi[3].lines() == ()
    chip.store(SPI3 + DR, 2, 0)
    chip.run(WORD)
    assert chip.spi[3].lines() == (IRQ["SPI3"],)


def test_the_gate_driver_tells_who_it_is_and_keeps_what_it_is_told(chip):
    begin(chip)
    enable(chip)
    assert read(chip, STATUS_2) == IDENTITY
    transfer(chip, CONTROL_1 << 11 | 0x3A8)
    assert read(chip, CONTROL_1) == 0x3A8
    # A frame of two words is void, and told.
    transfer(chip, CONTROL_1 << 11 | 0x111, CONTROL_1 << 11 | 0x222)
    assert transfer(chip, READ | STATUS_1 << 11) == 1 << 15
    assert read(chip, CONTROL_1) == 0x3A8
    chip.check()


def test_it_is_there_only_some_time_behind_its_enabling(chip):
    begin(chip)
    enable(chip, READY - 3 * WORD)
    transfer(chip, READ | STATUS_2 << 11)
    chip.run(2 * MS)
    # What was asked for before was not heard.
    assert transfer(chip, READ | STATUS_2 << 11) == 0
    assert transfer(chip, READ | STATUS_2 << 11) == STATUS_2 << 11 | IDENTITY
    transfer(chip, CONTROL_1 << 11 | 0x3A8)
    for low, kept in ((10 * US, 0x3A8), (100 * US, 0)):
        chip.store(GPIOB + 0x18, 4, 1 << 28)
        chip.run(low)
        enable(chip)
        assert read(chip, CONTROL_1) == kept
    chip.check()


def test_a_fault_of_it_is_seen_at_its_pin_and_in_its_status(chip):
    begin(chip)
    enable(chip)
    chip.driver.show(1 << 5)
    assert chip.pins.level("PD2") == 0
    assert read(chip, STATUS_1) == FAULT | 1 << 5
    chip.check()


MISUSES = [
    ("its settings while it is on", lambda chip: chip.store(SPI3 + CR1, 4, SETTINGS & ~1 | ON), "settings change"),
    ("the end in the middle of a word", lambda chip: (chip.store(SPI3 + DR, 2, 0), chip.store(SPI3 + CR1, 4, SETTINGS)), "in the middle of a word"),
    ("a third word", lambda chip: [chip.store(SPI3 + DR, 2, 0) for _ in range(3)], "while a word waits"),
    ("a byte of sixteen bits", lambda chip: chip.store(SPI3 + DR, 1, 0), "1 bytes"),
    ("DMA", lambda chip: chip.store(SPI3 + CR2, 2, 1), "CR2 .* 0x1 do"),
    ("a frame format of another maker", lambda chip: chip.store(SPI3 + CR2, 2, 1 << 4), "CR2 .* 0x10 do"),
]


@pytest.mark.parametrize(("misuse", "told"), [entry[1:] for entry in MISUSES], ids=[entry[0] for entry in MISUSES])
def test_what_is_forbidden_is_told(chip, misuse, told):
    begin(chip)
    chip.check()
    misuse(chip)
    with pytest.raises(Breach, match=told):
        chip.check()


@pytest.mark.parametrize(
    ("settings", "told"),
    [(SETTINGS & ~4, "another use than a master"), (SETTINGS & ~(1 << 8), "another use than a master"), (SETTINGS & ~1, "mode 0"), (SETTINGS & ~0x38, "21000000 Hz")],
    ids=["a slave", "a chip select of its own", "a mode that the device has not", "a clock that is too fast for it"],
)
def test_a_master_that_does_not_suit_its_device_is_told(chip, settings, told):
    with pytest.raises(Breach, match=told):
        begin(chip, settings)
        enable(chip)
        transfer(chip, 0)
        chip.check()


def test_a_pin_that_is_missing_is_told(chip):
    chip.store(GPIOC, 4, chip.load(GPIOC, 4) & ~0x30_0000)
    begin(chip)
    with pytest.raises(Breach, match="PB3 or PC10"):
        chip.check()
