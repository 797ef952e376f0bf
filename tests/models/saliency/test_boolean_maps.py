import numpy as np

from ipcli.models.saliency.boolean_maps import boolean_map_saliency, surrounded, whitened


def test_what_touches_the_border_is_not_surrounded():
    figure = np.zeros((20, 20), np.uint8)
    figure[5:9, 5:9] = 1
    figure[12:20, 12:16] = 1
    found = surrounded(figure)
    assert found[5:9, 5:9].all()
    assert found.sum() == 16


def test_a_surrounded_patch_stands_out_and_one_at_the_border_does_not():
    picture = np.full((60, 80, 3), 60, np.uint8)
    picture[20:32, 30:42] = 200
    picture[48:60, 60:72] = 200
    found = boolean_map_saliency(picture)
    assert found[26, 36] > 0
    assert found[54, 66] == 0


def test_small_figures_count_more_than_large_ones():
    picture = np.full((80, 120, 3), 60, np.uint8)
    picture[30:40, 15:25] = 200
    small = boolean_map_saliency(picture)[35, 20]
    picture[30:40, 15:25] = 60
    picture[20:60, 50:100] = 200
    assert small > 2 * boolean_map_saliency(picture)[40, 75]


def test_whitened_colours_are_stretched_and_uncorrelated():
    rng = np.random.default_rng(1)
    mixed = rng.normal(0, 20, (30, 40, 3)) @ np.array([[1, 0.8, 0.1], [0, 0.5, 0.2], [0, 0, 0.4]]) + 128
    white = whitened(np.clip(mixed, 0, 255).astype(np.uint8))
    assert white.min() == 0
    assert white.max() == 255
    off = np.corrcoef(white.reshape(-1, 3).T) - np.eye(3)
    assert np.abs(off).max() < 0.05
