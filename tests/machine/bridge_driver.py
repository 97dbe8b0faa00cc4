"""A driver of two full bridges as far as a program can tell (DRV8412, TI, SLES242): an enable without which all switches are off, and a line that tells of
a fault until the enable rises again."""


class BridgeDriver:
    """Its inputs are TIM1's pins. A fault takes nothing away here: who hears of it has to."""

    def __init__(self, chip, enable, fault):
        self.chip, self.fault = chip, fault
        self.is_on, self.is_broken = False, False
        #: Called when the switches go on or off.
        self.on_change = lambda: None
        chip.pins.watchers[enable] = self.on_enable
        chip.pins.drive(fault, 1)

    def on_enable(self, level):
        was_on, self.is_on = self.is_on, level == 1
        if self.is_on and not was_on:
            self.show()
        if self.is_on != was_on:
            self.on_change()

    def breaks(self, is_broken=True):
        """What is wrong with it comes, or goes: the line stays low until the next rise of the enable."""
        self.is_broken = is_broken
        if is_broken:
            self.show()

    def show(self):
        self.chip.pins.drive(self.fault, int(not self.is_broken))
