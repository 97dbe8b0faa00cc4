"""TIM2 (RM0090, 18): counts what TIM1 shows it, and captures the count at edges of its pins. That of a servo counts up and down and switches a
brake resistor: channel 3 its lower switch, channel 4 its upper one."""

from .interrupts import IRQ
from .timers import Timer, registers

#: Pins of the channels 1, 2 and 4.
PINS = {"PA0": 1, "PA1": 2, "PB11": 4}


class Tim2(Timer):
    NAME, CLOCK = "TIM2", (0x40, 0)
    FULL = 0xFFFF_FFFF
    REGISTERS = registers(
        32, CR1=0xA5, ARR=FULL, CCR3=FULL, CCR4=FULL, SMCR=0xFFF7, DIER=0x1E, EGR=1, CCMR1=0xF3F3, CCMR2=0xFBFB, CCER=0xBBBB, CNT=FULL,
    )  # fmt: skip

    def write_SMCR(self, value):
        # External clock mode 1 by the internal trigger 0, which is TIM1.
        if value not in (0, 7):
            self.breach(f"SMCR {value:#x}: neither standing nor counting TIM1")
        self["SMCR"] = value

    def counts(self):
        return self["CR1"] & 1 and self["SMCR"] & 0x77 == 7 and self.chip.tim1["CR2"] >> 4 & 7 == 4

    def count(self, pulses):
        if self.counts():
            self["CNT"] = self["CNT"] + pulses & 0xFFFF_FFFF

    def read_CNT(self):
        self.chip.tim1.settle(self.chip.now())
        return self["CNT"]

    def write_CCER(self, value):
        for pin, channel in PINS.items():
            bit = 1 << 4 * (channel - 1)
            if self["CCMR2"] == 0x7868:
                continue
            if value & ~self["CCER"] & bit:
                self.chip.pins.floats(pin, f"{self.NAME} channel {channel}")
        self["CCER"] = value

    def write_EGR(self, value):
        if value:
            self["CNT"] = 0

    def write_CCMR1(self, value):
        self.capture_mode("CCMR1", value)

    def write_CCMR2(self, value):
        if value == 0x7868:
            self["CCMR2"] = value
        else:
            self.capture_mode("CCMR2", value)

    def write_CCR3(self, value):
        self["CCR3"] = value
        self.check_brake()

    def write_CCR4(self, value):
        self["CCR4"] = value
        self.check_brake()

    def is_brake(self):
        return self["CR1"] & 0xE1 == 0xA1 and self["CCMR2"] == 0x7868 and self["CCER"] == 0x1100

    def check_brake(self):
        """The lower switch is on below CCR3, the upper one from CCR4 on: both at once would be a short of the bus."""
        if self.is_brake() and self["CCR3"] and self["CCR4"] <= self["ARR"] and self["CCR4"] - self["CCR3"] < 20:
            self.breach(f"CCR3 {self['CCR3']} and CCR4 {self['CCR4']} switch both sides of the brake on")

    def burns(self):
        """The share of the time in which the brake resistor is on."""
        return max(0, self["ARR"] - self["CCR4"]) / self["ARR"] if self.is_brake() else 0

    def capture_mode(self, name, value):
        if value & 0x0303 != 0x0101:
            self.breach(f"{name} {value:#x}: only capture is modelled")
        shift = 0 if name == "CCMR1" else 8
        if (self["CCER"] >> shift & 0x11) and (value ^ self[name]) & 0x0303:
            self.breach(f"{name}: the selection is written while the channel is on")
        self[name] = value

    def pin(self, pin, level):
        channel = PINS.get(pin)
        if channel is None or self.chip.gpio[pin[1]].function(int(pin[2:])) != 1:
            return
        edges = self["CCER"] >> 4 * (channel - 1)
        if not edges & 1 or not {0: level, 2: not level}.get(edges & 10, True):
            return
        flag = 1 << channel
        if self["SR"] & flag:
            self["SR"] |= flag << 8
        self.chip.tim1.settle(self.chip.time)
        self[f"CCR{channel}"] = self["CNT"]
        self["SR"] |= flag

    def captured(self, channel):
        self["SR"] &= ~(1 << channel)
        return self[f"CCR{channel}"]

    def read_CCR1(self):
        return self.captured(1)

    def read_CCR2(self):
        return self.captured(2)

    def read_CCR4(self):
        return self.captured(4)

    def lines(self):
        return (IRQ["TIM2"],) if self.r[0x10] & self.r[0x0C] & 0x1E else ()
