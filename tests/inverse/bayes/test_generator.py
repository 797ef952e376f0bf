"""A generator goes on where its state was taken."""

import numpy as np
import pytest

from ipcli.inverse.bayes import generator


def test_it_goes_on_where_the_state_was_taken():
    rng = np.random.default_rng(3)
    rng.integers(7, size=3, dtype=np.uint32)  # leaves half of a word for later
    words = generator.state(rng)
    assert words.shape == (6,)
    assert words.dtype == np.uint64
    expected = rng.integers(1000, size=5, dtype=np.uint32), rng.standard_normal(20)
    other = np.random.default_rng(99)
    generator.restore(other, words)
    found = other.integers(1000, size=5, dtype=np.uint32), other.standard_normal(20)
    for one, wanted in zip(found, expected, strict=True):
        np.testing.assert_array_equal(one, wanted)


def test_another_generator_is_refused():
    with pytest.raises(ValueError, match="PCG64"):
        generator.state(np.random.Generator(np.random.MT19937(0)))
