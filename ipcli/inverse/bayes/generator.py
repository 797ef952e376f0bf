"""The state of a random generator as an array, so that an interrupted chain can be stored without pickle."""

from __future__ import annotations

import numpy as np

WORD = (1 << 64) - 1


def state(rng: np.random.Generator) -> np.ndarray:
    """(6,) uint64 for a PCG64 generator, as numpy.random.default_rng makes it. ValueError for another."""
    about = rng.bit_generator.state
    if about["bit_generator"] != "PCG64":
        raise ValueError(f"expected a PCG64 generator, got {about['bit_generator']}")
    numbers = [about["state"][name] >> shift & WORD for name in ("state", "inc") for shift in (0, 64)]
    return np.array([*numbers, about["has_uint32"], about["uinteger"]], np.uint64)


def restore(rng: np.random.Generator, words: np.ndarray) -> None:
    """Bring a PCG64 generator to that state."""
    low, high, inc_low, inc_high, has_uint32, uinteger = (int(word) for word in words)
    rng.bit_generator.state = {
        "bit_generator": "PCG64",
        "state": {"state": low | high << 64, "inc": inc_low | inc_high << 64},
        "has_uint32": has_uint32,
        "uinteger": uinteger,
    }
