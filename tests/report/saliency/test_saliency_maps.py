import numpy as np

from ipcli.report.saliency import saliency_maps
from tests.fixtures.pages import ESCAPED, HOSTILE, Balance


def test_pictures_and_surfaces_are_shown_with_what_predicted_them(provenance):
    points = np.random.default_rng(0).normal(size=(200, 3)).astype(np.float32)
    arrays = {
        "model": np.array(HOSTILE),
        "pictures/a/picture": np.full((30, 40, 3), 90, np.uint8),
        "pictures/a/map": np.ones((15, 20), np.float32),
        "surfaces/b/points": points,
        "surfaces/b/normals": points / np.linalg.norm(points, axis=1, keepdims=True),
        "surfaces/b/map": np.ones(200, np.float32),
    }
    html = saliency_maps.page(arrays, provenance)
    assert ESCAPED in html
    assert HOSTILE not in html
    assert len(Balance(html).pictures) >= 6


def test_only_so_many_pictures_are_shown_and_that_is_said(provenance):
    arrays = {"model": np.array("x")}
    for k in range(saliency_maps.MOST + 3):
        arrays |= {f"pictures/{k}/picture": np.zeros((8, 8, 3), np.uint8)}
        arrays |= {f"pictures/{k}/map": np.ones((8, 8), np.float32)}
    assert "3 more are in the file" in saliency_maps.page(arrays, provenance)
