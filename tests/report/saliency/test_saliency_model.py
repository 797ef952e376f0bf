import numpy as np

from ipcli.report.saliency import saliency_model
from tests.fixtures.pages import ESCAPED, HOSTILE, Balance


def test_the_heaviest_feature_comes_first_and_trees_are_counted(provenance):
    arrays = {
        "subject": np.array("pictures"),
        "features": np.array(["light", HOSTILE]),
        "weights": np.array([0.1, -2.0]),
        "items": np.array(["a", "b"]),
        "fixations": np.array(12),
        "trees/feature": np.array([[1, 0, 0]]),
        "trees/left": np.array([[1, -1, -1]]),
    }
    html = saliency_model.page(arrays, provenance)
    Balance(html)
    assert "1 boosted trees" in html
    html = html[html.index("What it goes by") :]
    assert html.index(ESCAPED) < html.index("light")
    assert "\N{MINUS SIGN}2" in html
