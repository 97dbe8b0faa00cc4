"""DMA2 (RM0090, 10), stream 5: words from memory to TIM1_DMAR, round and round, in direct mode or through its FIFO."""

import random

from .engine import RAM
from .registers import Peripheral, Register

EN, CIRC, MINC = 1, 1 << 8, 1 << 10
DMAR = 0x4001_004C
TCIF, TEIF = 1 << 11, 1 << 9
FLAGS = 0x3D << 6
WORDS = 5

#: FCR: by the FIFO. It has four words; FS by how many are there.
DMDIS, ROOM, LEVELS = 4, 4, (4, 1, 2, 3, 5)


class Dma2(Peripheral):
    NAME = "DMA2"
    READ_SIZES = WRITE_SIZES = (4,)
    CLOCK = (0x30, 22)
    REGISTERS = {
        0x04: Register("HISR", 0),
        0x0C: Register("HIFCR", 0x0F7D_0F7D),
        0x88: Register("CR", 0x0FEF_FFFF),
        0x8C: Register("NDTR", 0xFFFF),
        0x90: Register("PAR"),
        0x94: Register("M0AR"),
        0x9C: Register("FCR", 0x87, 0x21, keep=False),
    }
    #: Core clocks from the update event to the last of five words, when nobody else is on the buses: 12 for a word.
    BURST = 60
    #: What a word waits at most while the core runs: for one access of the core to the memory, and one over the bridge of APB2.
    CONTENTION = 4

    #: Whether NDTR counts the word that is fetched before it is asked for.
    fetches_ahead = False

    def __init__(self, chip):
        self.chance = random.Random(1)
        super().__init__(chip)

    def reset(self):
        super().reset()
        self.total = 0
        #: What has been read ahead, and which word of memory comes next.
        self.fifo, self.fetched = [], 0

    def read_NDTR(self):
        left = self["NDTR"]
        if self.fetches_ahead and self["CR"] & EN:
            return left - 1 or self.total
        return left

    def locked(self, name, value):
        if self["CR"] & EN:
            self.breach(f"S5{name} written with {value:#x} while the stream is on")
            return
        self[name] = value

    def write_PAR(self, value):
        self.locked("PAR", value)

    def write_M0AR(self, value):
        self.locked("M0AR", value)

    def write_FCR(self, value):
        self.locked("FCR", value)

    def write_NDTR(self, value):
        self.locked("NDTR", value)
        self.total = value

    def write_HIFCR(self, value):
        self["HISR"] &= ~value

    def write_CR(self, value):
        if self["CR"] & EN and (value ^ self["CR"]) & ~(EN | 0x1E):
            self.breach(f"S5CR {value:#x}: its settings change while the stream is on")
        if value & EN and not self["CR"] & EN:
            self.check(value)
            self.fifo, self.fetched = [], 0
            if self["FCR"] & DMDIS:
                self.fill()
        self["CR"] = value

    def read_FCR(self):
        return self["FCR"] & 0x87 | LEVELS[len(self.fifo)] << 3

    def word(self, number):
        """A word of the memory."""
        address = self["M0AR"] - RAM + 4 * number
        return int.from_bytes(self.chip.engine.ram[address : address + 4], "little")

    def fill(self):
        """The FIFO reads ahead until it is full."""
        while len(self.fifo) < ROOM:
            self.fifo.append(self.word(self.fetched))
            self.fetched = (self.fetched + 1) % self.total

    def drain(self):
        """A word leaves the FIFO, which is filled again once it has as few as its threshold says."""
        word = self.fifo.pop(0)
        if len(self.fifo) <= (self["FCR"] & 3) + 1:
            self.fill()
        return word

    def check(self, cr):
        if self["HISR"] & FLAGS:
            self.breach("the stream is switched on while flags of it are set")
        wanted = 6 << 25 | 2 << 13 | 2 << 11 | MINC | CIRC | 1 << 6
        if cr & (7 << 25 | 0xF << 11 | MINC | CIRC | 3 << 6) != wanted:
            self.breach(f"S5CR {cr:#x}, S5FCR {self['FCR']:#x}: another use of the stream is not modelled")
        begin, end = self["M0AR"], self["M0AR"] + 4 * self.total
        if begin % 4 or not 0x2000_0000 <= begin < end <= 0x2002_0000:
            self.breach(f"S5M0AR {begin:#x}: it cannot reach this")
        if self["PAR"] != DMAR:
            self.breach(f"S5PAR {self['PAR']:#x} is not TIM1_DMAR")

    def burst_clocks(self):
        """How long the burst that is asked for now takes: each word waits for what the core may have on the buses, drawn from a seed."""
        core = self.chip.core
        if core.sleeping or core.is_stopped:
            return self.BURST
        return self.BURST + sum(self.chance.randint(0, self.CONTENTION) for _ in range(WORDS))

    def burst(self):
        """TIM1 asks for what its DCR says."""
        if not self["CR"] & EN:
            return
        tim1, ram = self.chip.tim1.r, self.chip.engine.ram
        dcr, left, ahead = tim1[0x48], self.r[0x8C], self.r[0x9C] & DMDIS
        address = self.r[0x94] - RAM + 4 * (self.total - left)
        for register in range(4 * (dcr & 31), 4 * ((dcr & 31) + (dcr >> 8 & 31) + 1), 4):
            # The lower half of a word is what these registers have.
            tim1[register] = self.drain() & 0xFFFF if ahead else ram[address] | ram[address + 1] << 8
            address += 4
            left -= 1
            if left == 0:
                left, address = self.total, self.r[0x94] - RAM
                self["HISR"] |= TCIF
        self.r[0x8C] = left

    def fail(self):
        """A transfer error: the stream is switched off."""
        self["CR"] &= ~EN
        self["HISR"] |= TEIF
