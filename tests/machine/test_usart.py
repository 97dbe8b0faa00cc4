"""Serial lines: registers are written as a program would."""

import pytest
from stm32f405 import HZ, US, Breach, Chip
from stm32f405.interrupts import IRQ
from stm32f405.usart import FE, ORE, RXNE, TC, TXE

RCC, GPIOA, USART2 = 0x2_3800, 0x2_0000, 0x4400
SR, DR, BRR, CR1, CR2 = 0x00, 0x04, 0x08, 0x0C, 0x10
#: On, both ways.
ON = 1 << 13 | 1 << 3 | 1 << 2
#: 1 Mbit/s from 42 MHz.
DIVIDER, BYTE = 42, 10 * 168


@pytest.fixture
def chip(image):
    chip = Chip(image)
    chip.core.is_stopped = True
    chip.store(RCC + 0x30, 4, chip.load(RCC + 0x30, 4) | 1)
    chip.store(RCC + 0x40, 4, 1 << 17)
    chip.store(GPIOA + 0x20, 4, 0x7700)
    chip.store(GPIOA, 4, chip.load(GPIOA, 4) | 0xA0)
    yield chip
    chip.leave()


def begin(chip, enables=ON):
    chip.store(USART2 + BRR, 4, DIVIDER)
    chip.store(USART2 + CR1, 4, enables)


def status(chip):
    return chip.load(USART2 + SR, 4) & (TXE | TC | RXNE | ORE | FE)


def test_bytes_leave_one_behind_the_other(chip):
    begin(chip)
    sent, since = [], chip.time
    chip.usart[2].on_byte = lambda byte, at: sent.append((byte, at - since))
    chip.store(USART2 + DR, 4, 0x41)
    assert status(chip) == TXE
    chip.store(USART2 + DR, 4, 0x42)
    assert status(chip) == 0
    chip.run(BYTE)
    assert status(chip) == TXE
    chip.run(BYTE)
    assert status(chip) == TXE | TC
    assert sent == [(0x41, BYTE), (0x42, 2 * BYTE)]
    chip.check()


def test_what_comes_is_read_once_and_what_is_not_read_in_time_is_lost(chip):
    begin(chip)
    chip.usart[2].receive(b"ABC")
    chip.run(BYTE)
    assert status(chip) == TXE | TC | RXNE
    assert chip.load(USART2 + DR, 4) == 0x41
    assert status(chip) == TXE | TC
    chip.run(2 * BYTE)
    assert status(chip) == TXE | TC | RXNE | ORE
    assert chip.load(USART2 + DR, 4) == 0x42
    chip.check()


@pytest.mark.parametrize(("rate", "is_wrong"), [(1_000_000, False), (1_020_000, False), (950_000, True), (500_000, True)])
def test_a_sender_with_another_rate_is_not_understood(chip, rate, is_wrong):
    begin(chip)
    chip.usart[2].line_bit = HZ // rate
    chip.usart[2].receive(b"A")
    chip.run(40 * US)
    assert bool(status(chip) & FE) == is_wrong
    assert (chip.load(USART2 + DR, 4) == 0x41) != is_wrong


@pytest.mark.parametrize(("enable", "before", "behind"), [(1 << 7, True, True), (1 << 6, True, True), (1 << 5, False, True)], ids=["TXE", "TC", "RXNE"])
def test_its_interrupts_are_asked_for_one_by_one(chip, enable, before, behind):
    begin(chip, ON | enable)
    assert bool(chip.usart[2].lines()) == before
    chip.usart[2].receive(b"A")
    chip.run(BYTE)
    assert chip.usart[2].lines() == ((IRQ["USART2"],) if behind else ())


MISUSES = [
    ("a byte while it is off", lambda chip: chip.store(USART2 + DR, 4, 0), "while it is off"),
    ("a third byte", lambda chip: (begin(chip), [chip.store(USART2 + DR, 4, 0) for _ in range(3)]), "while a byte waits"),
    ("no rate", lambda chip: chip.store(USART2 + CR1, 4, ON), "without BRR"),
    ("no pin", lambda chip: (chip.store(GPIOA + 0x20, 4, 0), begin(chip)), "PA2 or PD5"),
    ("another rate in a byte", lambda chip: (begin(chip), chip.store(USART2 + DR, 4, 0), chip.store(USART2 + BRR, 4, 84)), "in the middle of a byte"),
    ("two stop bits", lambda chip: chip.store(USART2 + CR2, 4, 2 << 12), "CR2 .* 0x2000 do"),
    ("parity", lambda chip: begin(chip, ON | 1 << 10), "CR1 .* 0x400 do"),
]


@pytest.mark.parametrize(("misuse", "told"), [entry[1:] for entry in MISUSES], ids=[entry[0] for entry in MISUSES])
def test_what_is_forbidden_is_told(chip, misuse, told):
    misuse(chip)
    with pytest.raises(Breach, match=told):
        chip.check()
