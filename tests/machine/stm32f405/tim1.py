"""TIM1 (RM0090, 17). As a stepper drive has it: channel 1N makes step pulses in PWM mode 1, channel 2N the direction, each update event asks for a
burst of DMA, and the break input cuts the outputs off. That of a servo counts up and down (`pwm.py`). Other uses are breaches."""

from collections import namedtuple

from .clock import NEVER
from .interrupts import IRQ
from .pwm import ARPE, CEN, CMS, DIR, URS, Centre
from .registers import Peripheral, Register

MOE, BKE, BKP = 1 << 15, 1 << 12, 1 << 13
UIF, CC4IF, BIF, UDE = 1, 1 << 4, 1 << 7, 1 << 8
STEP, DIRECTION, BREAK = 13, 14, 12

#: The interrupt of each flag.
ASKS = {BIF: "TIM1_BRK", UIF: "TIM1_UP", CC4IF: "TIM1_CC"}

#: What acts: the preloaded registers as the last update event has taken them.
Run = namedtuple("Run", "begin period repeat width forward")


class Tim1(Peripheral):
    NAME = "TIM1"
    CLOCK = (0x44, 0)
    REGISTERS = {
        0x00: Register("CR1", 0x3FF, known=0x3F5),
        0x04: Register("CR2", 0x7FFD, known=0x70),
        0x08: Register("SMCR", 0xFFF7, known=0),
        0x0C: Register("DIER", 0x7FFF, known=UDE | BIF | CC4IF | UIF),
        0x10: Register("SR", 0, rc_w0=0x1EFF, keep=False),
        0x14: Register("EGR", 0xFF),
        0x18: Register("CCMR1", 0xFFFF, known=0x7878),
        0x1C: Register("CCMR2", 0xFFFF, known=0x7878),
        0x20: Register("CCER", 0x3FFF),
        0x24: Register("CNT", 0xFFFF, known=0),
        0x28: Register("PSC", 0xFFFF, known=0),
        0x2C: Register("ARR", 0xFFFF, 0xFFFF),
        0x30: Register("RCR", 0xFF),
        0x34: Register("CCR1", 0xFFFF),
        0x38: Register("CCR2", 0xFFFF),
        0x3C: Register("CCR3", 0xFFFF),
        0x40: Register("CCR4", 0xFFFF),
        0x44: Register("BDTR", 0xFFFF, known=0xBFFF),
        0x48: Register("DCR", 0x1F1F),
        0x4C: Register("DMAR"),
    }

    def __init__(self, chip):
        #: Runs with pulses, for who judges them; pulses that left the pin, and the position they make.
        self.log, self.pulses, self.position = [], 0, 0
        self.bursts = self.late_bursts = 0
        self.centre = None
        super().__init__(chip)
        self.centre = Centre(self)

    def reset(self):
        super().reset()
        if self.centre is not None:
            self.centre.reset()
        self.run, self.counted = None, 0
        self.active = Run(0, 0x10000, 1, 0, False)
        self.burst_at = NEVER

    # Pulses.

    def makes_pulses(self):
        return self.r[0x18] >> 4 & 7 == 6

    def drives(self, pin):
        """Whether the timer's level is at this pin of port B."""
        return self["BDTR"] & MOE and self["CCER"] >> (2 if pin == STEP else 6) & 1 and self.chip.gpio["B"].function(pin) == 1

    def step_level(self):
        """The level of the step signal at its pin."""
        if self.run is None or not self.makes_pulses() or not self.drives(STEP):
            return 0
        return (self.chip.now() - self.run.begin) % self.run.period < self.run.width

    def settle(self, now):
        """Counts the pulses that have begun."""
        run = self.run
        if run is None or not run.width or not self.makes_pulses():
            return
        begun = min((now - run.begin) // run.period, run.repeat - 1) + 1
        new = begun - self.counted
        if new > 0:
            self.chip.tim2.count(new)
            if self.drives(STEP):
                self.pulses += new
                self.position += new if run.forward else -new
                self.last_pulse = run.begin + (begun - 1) * run.period
            self.counted = begun

    last_pulse = None

    def update(self, now):
        """An update event: what is preloaded acts."""
        period = self["ARR"] + 1
        self.active = Run(now, period, (self["RCR"] & 0xFF) + 1, self["CCR1"], self["CCR2"] >= period)
        self.run, self.counted = self.active, 0
        if self.active.width:
            self.log.append(self.active)
        self.settle(now)

    def write_CR1(self, value):
        now, old = self.chip.now(), self["CR1"]
        self.settle(now)
        if old & value & CEN and (old ^ value) & (CMS | ARPE):
            self.breach(f"CR1 {value:#x}: the way it counts changes while it does")
        self["CR1"] = value & ~DIR
        if value & CMS:
            if value & CEN and not old & CEN:
                self.centre.start(now)
            elif not value & CEN:
                self.centre.stop()
            return
        if value & (DIR | 3 << 8):
            self.breach(f"CR1 {value:#x}: downwards, or with another clock for dead times, is not modelled")
        if value & CEN and self.run is None:
            self.check_outputs()
            self.run, self.counted = self.active._replace(begin=now), 0
            self.check_steps()
        elif not value & CEN:
            self.run = None

    def read_CR1(self):
        return self["CR1"] | (DIR if self["CR1"] & CMS and not self.centre.is_up else 0)

    def check_steps(self):
        """A train of steps has two outputs and no more."""
        if self.run is not None and (self["CCER"] & ~0x44 or self["CCMR2"] or self["BDTR"] & 0xFF or self["DIER"] & (UIF | CC4IF)):
            self.breach("outputs, interrupts or a dead time that a train of steps does not have")

    def write_DIER(self, value):
        self["DIER"] = value
        self.check_steps()

    def write_CCER(self, value):
        self["CCER"] = value
        self.check_steps()
        if self.centre.begin is not None:
            self.centre.check_outputs()
            self.centre.on_change()

    def write_CCMR2(self, value):
        if value & 0x0303:
            self.breach(f"CCMR2 {value:#x} is not modelled")
        self["CCMR2"] = value
        self.check_steps()

    def check_outputs(self):
        for pin in (STEP, DIRECTION, BREAK):
            if self.chip.gpio["B"].function(pin) != 1:
                self.breach(f"started while PB{pin} is not its pin")
        self.chip.pins.floats(f"PB{BREAK}", "the break input")

    def write_EGR(self, value):
        if value & ~1:
            self.breach(f"EGR {value:#x} is not modelled")
        if value & 1:
            now = self.chip.now()
            self.settle(now)
            if not self["CR1"] & 4 and self["DIER"] & UDE:
                self.breach("UG without URS asks for DMA")
            running = self.run is not None
            if self["CR1"] & CMS and self["CR1"] & CEN:
                self.breach("UG while it counts up and down is not modelled")
            self.centre.take_preload()
            if not self["CR1"] & URS:
                self["SR"] |= UIF
            self.update(now)
            if not running:
                self.run = None

    def write_CCMR1(self, value):
        mode = value >> 4 & 7
        if mode not in (0, 4, 6, 7) or value & 0x0303:
            self.breach(f"CCMR1 {value:#x} is not modelled")
        self.settle(self.chip.now())
        self["CCMR1"] = value

    def write_BDTR(self, value):
        lock = self["BDTR"] >> 8 & 3
        if lock and (value ^ self["BDTR"]) & ~MOE:
            self.breach(f"BDTR written under its lock {lock}")
        self.settle(self.chip.now())
        if value & MOE and self.break_level(value):
            value &= ~MOE
            self["SR"] |= BIF
        self["BDTR"] = value
        self.check_steps()
        self.centre.on_change()

    def write_DMAR(self, _):
        self.breach("DMAR written by the core")

    def write_DCR(self, value):
        if self.burst_at != NEVER:
            self.breach("DCR written while a burst is wanted")
        self["DCR"] = value

    def read_CNT(self):
        if self.centre.begin is not None:
            return self.centre.count(self.chip.now())
        return (self.chip.now() - self.run.begin) % self.run.period if self.run else 0

    # The break input.

    def break_level(self, bdtr=None):
        bdtr = self["BDTR"] if bdtr is None else bdtr
        if not bdtr & BKE or self.chip.gpio["B"].function(BREAK) != 1:
            return False
        return (self.chip.gpio["B"].level(BREAK) or 0) == (bdtr & BKP != 0)

    def pin(self, pin, _level):
        if pin == "PB12" and self.break_level():
            self.settle(self.chip.time)
            self["BDTR"] &= ~MOE
            self["SR"] |= BIF
            self.centre.on_change()

    def write_SR(self, value):
        # As long as the input is active the flag stands.
        self["SR"] = value | (BIF if self.break_level() else 0)

    # Time.

    def end(self):
        run = self.run
        return run.begin + run.period * run.repeat if run else NEVER

    def next_event(self):
        if self.centre.begin is not None:
            return self.centre.next_event()
        end = self.end()
        return end if end < self.burst_at else self.burst_at

    def event(self):
        if self.centre.begin is not None:
            return self.centre.event()
        end = self.end()
        if self.burst_at <= end:
            self.burst_at = NEVER
            self.chip.dma2.burst()
            self.bursts += 1
            return
        self.settle(end - 1)
        self["SR"] |= UIF
        self.update(end)
        if self["DIER"] & UDE:
            if self.burst_at != NEVER:
                self.late_bursts += 1
            self.burst_at = end + self.chip.dma2.burst_clocks()

    def lines(self):
        asked = self.r[0x10] & self.r[0x0C] & (BIF | UIF | CC4IF)
        return [IRQ[name] for flag, name in ASKS.items() if asked & flag] if asked else ()
