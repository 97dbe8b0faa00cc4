"""The converter ADC1 (RM0090, 13), one regular channel at a time."""

from .clock import HZ, NEVER
from .registers import Peripheral, Register

#: Clocks of sampling by SMP, to which 12 for the conversion come.
SAMPLING = (3, 15, 28, 56, 84, 112, 144, 480)


class Adc(Peripheral):
    NAME = "ADC1"
    READ_SIZES = WRITE_SIZES = (4,)
    CLOCK = (0x44, 8)
    REGISTERS = {
        0x00: Register("SR", 0, rc_w0=0x3F),
        0x08: Register("CR2", 0x7F7F_0F03, known=1 << 30 | 1),
        0x0C: Register("SMPR1", 0x07FF_FFFF),
        0x10: Register("SMPR2", 0x3FFF_FFFF),
        0x34: Register("SQR3", 0x3FFF_FFFF, known=0x1F),
        0x4C: Register("DR", 0),
        0x304: Register("CCR", 0x00C3_EF1F, known=1 << 23 | 3 << 16),
    }

    def reset(self):
        super().reset()
        self.done = NEVER
        self.on_at = NEVER
        #: What lies at the channels. 16 is the temperature of the chip: 960 is 34 °C with the calibration in `chip.py`.
        self.levels = {14: 2048, 16: 960}

    def write_CR2(self, value):
        now = self.chip.now()
        if value & 1 and not self["CR2"] & 1:
            self.on_at = now + 3 * HZ // 1_000_000
        if value & 1 << 30:
            if not self["CR2"] & 1 or now < self.on_at:
                self.breach("started while it is off or not yet stable")
            channel = self["SQR3"] & 31
            time = self["SMPR1"] >> 3 * (channel - 10) & 7 if channel >= 10 else self["SMPR2"] >> 3 * channel & 7
            divider = 2 * ((self["CCR"] >> 16 & 3) + 1)
            # Two core clocks are one of APB2.
            self.done = now + 2 * divider * (SAMPLING[time] + 12)
            value &= ~(1 << 30)
        self["CR2"] = value

    def read_DR(self):
        self["SR"] &= ~2
        return self.levels.get(self["SQR3"] & 31, 0)

    def next_event(self):
        return self.done

    def event(self):
        self.done = NEVER
        self["SR"] |= 2
