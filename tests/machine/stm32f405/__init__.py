"""An STM32F405, register by register: what the flashed image meets in the tests.

Written from RM0090 (the chip) and PM0214 (the core). The core's instructions are unicorn's; exceptions, the system control space and every
peripheral are here, one module for each. It is strict: what the manuals forbid, and what is not modelled, is a `Breach`, with address, PC
and source line, and ends the run.

Time counts in clocks of the core, 168 MHz; an instruction takes one, but where the model of cost (`cost.py`) is switched on. What a peripheral does
has its exact moment; what the core does is exact to a slice of 400 instructions.
"""

from .chip import Chip
from .clock import HZ, MS, US, NEVER
from .registers import Breach

__all__ = ["Breach", "Chip", "HZ", "MS", "NEVER", "US"]
