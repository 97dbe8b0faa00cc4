"""A drive that is commanded by SDO, as the tests of the machine do."""

from stm32f405 import MS

#: Words of 6040h on the way to Operation enabled.
SHUTDOWN, SWITCH_ON, ENABLE, HALT, QUICK_STOP, FAULT_RESET = 0x06, 0x07, 0x0F, 0x10F, 0x02, 0x80

PROFILE_POSITION, PROFILE_VELOCITY, CYCLIC_POSITION = 1, 3, 8

STATE = 0x6F
OPERATION_ENABLED, SWITCH_ON_DISABLED, FAULT = 0x27, 0x40, 0x08


class Drive:
    """`sdo` of the node, the chip under it, and what its pins show."""

    def __init__(self, bench, node):
        self.bench, self.chip, self.sdo = bench, bench.chip, node.sdo

    def __getitem__(self, index):
        return self.sdo[index].raw

    def __setitem__(self, index, value):
        self.sdo[index].raw = value

    def state(self):
        return self[0x6041] & STATE

    def until(self, is_true, what, milliseconds=2_000):
        end = self.chip.time + milliseconds * MS
        while not is_true():
            assert self.chip.time < end, f"{what}: not within {milliseconds} ms"
            self.bench.milliseconds(2)

    def enable(self, mode):
        self[0x6060] = mode
        for word in (SHUTDOWN, SWITCH_ON, ENABLE):
            self[0x6040] = word
            self.bench.milliseconds(5)
        self.until(lambda: self.state() == OPERATION_ENABLED, "enabled")
        return self

    def turn(self, velocity, acceleration=1_000_000):
        """Profile velocity, until it is reached."""
        self[0x6083] = self[0x6084] = acceleration
        self.enable(PROFILE_VELOCITY)
        self[0x60FF] = velocity
        self.until(lambda: self[0x606C] == velocity, f"{velocity} steps/s")
        return self

    # The pins.

    def has_power(self):
        return self.chip.pins.level("PA2") == 0

    def brake_is_open(self):
        return self.chip.pins.level("PC2") == 1

    def is_safe(self):
        """No current, the brake closed, and no level at the step pin."""
        return not self.has_power() and not self.brake_is_open() and not self.chip.tim1.step_level()

    def settle(self):
        """The pulses up to now are counted."""
        self.chip.tim1.settle(self.chip.time)
        return self.chip.tim1.position
