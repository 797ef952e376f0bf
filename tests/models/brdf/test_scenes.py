"""Generated scenes: sound, and the same for the same seed."""

import numpy as np
import pytest

from ipcli.models.brdf import scenes


@pytest.mark.parametrize("sheets", [0.0, 1.0])
def test_scenes_are_in_one_piece_known_all_over_and_repeat(sheets):
    charts = [np.random.default_rng(0).uniform(size=(65, 65, 3))]
    for seed in range(4):
        a, b = (
            scenes.scene(scenes.surface(rng, 64, sheets), charts, rng)
            for rng in (np.random.default_rng(seed), np.random.default_rng(seed))
        )
        np.testing.assert_array_equal(a.picture, b.picture)
        mask = a.surface.mask
        assert a.surface.is_sheet == bool(sheets)
        assert np.isfinite(a.surface.height[mask]).all()
        assert np.isfinite(a.surface.normals[mask]).all()
        assert (a.surface.normals[mask][:, 2] >= 0).all()
        assert (a.picture[~mask] == 0).all()
        assert a.picture.max() <= 1
