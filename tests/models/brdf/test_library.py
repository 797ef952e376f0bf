"""A library comes back from its arrays; its grey maps have mean 1."""

import numpy as np
import pytest

from ipcli.models.brdf.library import Library
from ipcli.models.brdf.material import STATISTICS, Classifier
from ipcli.models.brdf.rim import FEATURES, Judge


def test_a_library_comes_back_from_its_arrays():
    rng = np.random.default_rng(0)
    f, m = len(FEATURES), len(STATISTICS)
    judge = Judge(rng.normal(size=1 + 2 * f), rng.normal(size=f), np.ones(f))
    classifier = Classifier(rng.normal(size=(m, 2)), np.zeros(2), np.zeros(m), np.ones(m), 0.7)
    charts = rng.uniform(0.5, 3, (4, 9, 9, 3)).astype(np.float32)
    shelf = Library(charts, np.array([0, 0, 1, 1]), np.array([0, 1, 0, 1]), ("a", "b"), ("p", "q"), judge, classifier)
    back = Library.of(shelf.arrays())
    assert (back.materials, back.probes) == (("a", "b"), ("p", "q"))
    assert back.classifier.temperature == 0.7
    for name, array in back.arrays().items():
        np.testing.assert_array_equal(array, shelf.arrays()[name])
    np.testing.assert_allclose(back.grey(), charts.mean(-1) / charts.mean(axis=(1, 2, 3))[:, None, None], rtol=1e-6)
    assert back.grey().mean(axis=(1, 2)) == pytest.approx(1)
