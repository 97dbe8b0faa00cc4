"""The independent watchdog (RM0090, 21), on an oscillator of its own."""

from .clock import HZ, NEVER
from .registers import Peripheral, Register



class Iwdg(Peripheral):
    NAME = "IWDG"
    READ_SIZES = WRITE_SIZES = (2, 4)
    #: Its oscillator in Hz; it has 17 to 47 kHz (data sheet, 5.3.9).
    lsi = 32_000
    REGISTERS = {
        0x00: Register("KR", 0xFFFF),
        0x04: Register("PR", 7),
        0x08: Register("RLR", 0xFFF, 0xFFF),
        0x0C: Register("SR", 0),
    }

    def reset(self):
        super().reset()
        self.open, self.started, self.deadline = False, None, NEVER
        #: What the counter works with: a write crosses only while the oscillator runs, which the start switches on.
        self.crossing = {}
        self.prescaler, self.reload = 0, 0xFFF
        self.fed = 0

    def settle(self):
        """Takes what has crossed."""
        if self.started is not None:
            now = self.chip.now()
            for name, at in list(self.crossing.items()):
                # Five clocks of the oscillator.
                if max(at, self.started) + 5 * HZ // self.lsi <= now:
                    del self.crossing[name]
                    if name == "PR":
                        self.prescaler = self["PR"]
                    else:
                        self.reload = self["RLR"]

    def clocks(self, counts):
        return counts * (4 << min(self.prescaler, 6)) * HZ // self.lsi

    def write_KR(self, value):
        now = self.chip.now()
        self.settle()
        self.open = value == 0x5555
        if value == 0xCCCC:
            if self.started is None:
                self.started = now
                # The prescaler is taken at once; the counter begins at its largest value.
                self.prescaler = self["PR"]
                self.deadline = now + self.clocks(0x1000)
        elif value == 0xAAAA:
            self.fed += 1
            if self.started is not None:
                self.deadline = now + self.clocks(self.reload + 1)
        elif value != 0x5555:
            self.breach(f"KR written with {value:#x}")
        self["KR"] = 0

    def write_PR(self, value):
        self.write_slow("PR", value)

    def write_RLR(self, value):
        self.write_slow("RLR", value)

    def write_slow(self, name, value):
        self.settle()
        if not self.open:
            return self.breach(f"{name} written without access")
        if name in self.crossing:
            return self.breach(f"{name} written while SR says that it is not through")
        self[name] = value
        self.crossing[name] = self.chip.now()

    def read_SR(self):
        self.settle()
        return ("PR" in self.crossing) | ("RLR" in self.crossing) << 1

    def next_event(self):
        return self.deadline

    def event(self):
        self.deadline = NEVER
        self.chip.reset("watchdog")
