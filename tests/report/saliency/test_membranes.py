"""The page of membranes."""

import json
import re

import numpy as np

from ipcli.models.saliency import membranes
from ipcli.models.saliency.scene_parameters import Membranes
from ipcli.report.saliency.membranes import turnable


def test_the_page_holds_every_moment_of_every_membrane_and_fetches_nothing():
    a = membranes.shown(np.array([[1.0, 1.2, 5.0], [0.4, 0.9, 2.0]]), 0.4, Membranes())
    page = turnable(a)
    found = json.loads(re.search(r"id='data'>(.*?)</script>", page)[1])
    shapes = np.array(found["shapes"]).reshape(a["membranes/shapes"].shape)
    assert shapes.shape[:2] == (2, len(found["times"]))
    top = np.abs(a["membranes/shapes"]).max(axis=(1, 2, 3), keepdims=True)
    assert np.abs(shapes - a["membranes/shapes"] / top).max() <= 5.1e-4
    assert np.abs(shapes[:, :, -1]).max() < 1e-2  # clamped at the rim
    assert "http" not in page.replace("http-equiv", "")
    assert "σ = 1" in page
    for meant in ("the greater σ", "z is the distance", "a the membrane's radius"):
        assert meant in page
