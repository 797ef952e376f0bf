import numpy as np
import pytest

from ipcli.report.saliency import saliency_evaluation
from tests.fixtures.pages import Balance


@pytest.fixture(params=["pictures", "surfaces"])
def arrays(request):
    made = {
        "subject": np.array(request.param),
        "protocol": np.array("2 folds"),
        "predictors": np.array(["ours", "centre", "edges", "red"]),
        "roles": np.array(["model", "baseline", "feature", "feature"]),
        "measures": np.array(["AUC", "sAUC"]),
        "values": np.array([[0.8712, 0.7], [0.74, 0.5], [0.61, np.nan], [0.66, 0.6]]),
        "items": np.array(["a"]),
        "each": np.full((4, 1, 2), 0.9),
        "looked_at": np.array([33]),
        "default": np.array("ours"),
        "notes": np.array(["too good"]),
        "shown/a/predictors": np.array(["ours", "centre"]),
    }
    if request.param == "pictures":
        made["shown/a/picture"] = np.zeros((20, 30, 3), np.uint8)
        made["shown/a/fixations"] = np.array([[0.5, 0.5]], np.float32)
        return made | {"shown/a/maps": np.random.default_rng(0).random((2, 15, 20)).astype(np.float32)}
    points = np.random.default_rng(0).normal(size=(150, 3)).astype(np.float32)
    made |= {"shown/a/points": points, "shown/a/normals": points, "shown/a/truth": np.ones(150, np.float32)}
    return made | {"shown/a/maps": np.ones((2, 150, 1), np.float32)}


def test_figures_notes_and_maps_are_shown(arrays, provenance):
    html = saliency_evaluation.page(arrays, provenance)
    assert "87.1 %" in html
    assert "too good" in html
    assert "33" in html
    assert len(Balance(html).pictures) == 3


def test_features_are_in_order_of_their_worth(arrays, provenance):
    html = saliency_evaluation.page(arrays, provenance)
    worth = html[html.index("What each feature is worth") :]
    assert worth.index("red") < worth.index("edges")
    assert "\N{EM DASH}" in worth
