"""Waiting for what a device sends and for what it becomes."""

import queue
import time

#: How long to wait for what must come, in seconds. The machine may be busy, so this is far more than a device needs.
PATIENCE = 20

#: How long to wait for what must not come, in seconds.
SILENCE = 0.3


class Frames:
    """Every frame with one identifier, from now on."""

    def __init__(self, network, cob_id):
        self.queue = queue.Queue()
        network.subscribe(cob_id, lambda _cob_id, data, _time: self.queue.put(bytes(data)))

    def next(self, timeout=PATIENCE):
        """The next frame."""
        try:
            return self.queue.get(timeout=timeout)
        except queue.Empty:
            raise AssertionError(f"no frame within {timeout} s") from None

    def until(self, wanted, timeout=PATIENCE):
        """Takes frames up to the first one that is wanted, and gives that one."""
        end = time.monotonic() + timeout
        seen = []
        while True:
            try:
                frame = self.queue.get(timeout=max(0, end - time.monotonic()))
            except queue.Empty:
                raise AssertionError(f"not among {[frame.hex(' ') for frame in seen]}") from None
            if wanted(frame):
                return frame
            seen.append(frame)

    def none(self, seconds=SILENCE):
        """Is there no frame for this time?"""
        try:
            self.queue.get(timeout=seconds)
        except queue.Empty:
            return True
        return False


def wait_until(true, what, timeout=PATIENCE):
    """Looks again and again until it is true."""
    end = time.monotonic() + timeout
    while not true():
        assert time.monotonic() < end, f"{what}: not within {timeout} s"
        time.sleep(0.002)
