"""Random numbers by counting: what is drawn for a sample depends on what it is for, and on nothing drawn before.

Philox turns a key and a counter into bits. The key is a digest of seed, scenario and subject (a brick, or a variable),
the counter is the number of the sample, and of the attempt where the first does not do. So a sample is the same on
every machine, in every order, and whatever else is drawn.
"""

from dataclasses import dataclass
from hashlib import sha256
from typing import Final, TypeAlias

import numpy as np
from numpy.typing import NDArray

Array: TypeAlias = NDArray[np.float64]

EACH: Final = 4  # numbers that one count gives
BITS: Final = 53  # of a double


@dataclass(frozen=True, slots=True)
class Draws:
    """Samples of a scenario that follow each other."""

    seed: int
    scenario: str
    first: int  # the number of the first sample
    count: int

    def uniform(self, subject: str, attempt: int = 0) -> Array:
        """(EACH, count) numbers between 0 and 1, neither of them included."""
        digest = sha256(f"{self.seed}\n{self.scenario}\n{subject}".encode()).digest()
        key = np.frombuffer(digest[:16], dtype="<u8").astype(np.uint64)
        counter = np.array([self.first, attempt, 0, 0], dtype=np.uint64)
        drawn = np.random.Philox(key=key, counter=counter).random_raw(EACH * self.count)
        numbers = ((drawn >> np.uint64(64 - BITS)).astype(np.float64) + 0.5) * 2.0**-BITS
        return numbers.reshape(self.count, EACH).T
