"""Errors as getError takes them, in closed form."""

import numpy as np
import pytest

from ipcli.models.brdf import evaluation


def test_a_tilted_plane_errs_by_its_angle_and_by_its_mean_height():
    mask = np.ones((21, 21), bool)
    flat, tilted = np.zeros((21, 21)), np.tile(np.arange(21.0), (21, 1))
    n, median, z = evaluation.errors(flat, mask, None, tilted)
    assert n == pytest.approx(np.pi / 4)
    assert median == pytest.approx(np.pi / 4)
    inner = np.arange(1, 20) - 10
    assert z == pytest.approx(np.abs(inner).mean())


def test_a_shift_of_the_height_is_no_error_and_a_scale_is():
    rng = np.random.default_rng(0)
    mask, z = np.ones((15, 15), bool), rng.normal(size=(15, 15))
    assert evaluation.height_error(z + 7, z, mask) == pytest.approx(0, abs=1e-12)
    assert evaluation.height_error(2 * z, z, mask) > 0.3


def test_unknown_heights_do_not_count():
    mask, z = np.ones((15, 15), bool), np.zeros((15, 15))
    z[3:6, 3:6] = np.nan
    assert evaluation.errors(np.zeros((15, 15)), mask, None, z) == [0.0, 0.0, 0.0]
