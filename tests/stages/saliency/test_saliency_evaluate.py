import csv

import numpy as np
import pytest

from ipcli.io.files import h5
from ipcli.models.saliency.parameters import FixationLearning, Validation
from ipcli.params import Run
from ipcli.stages.saliency import saliency_evaluate
from ipcli.stages.saliency.parameters import SaliencyEvaluate
from tests.fixtures.fixation_sets import write_pictures, write_surfaces

PARAMS = SaliencyEvaluate(2, FixationLearning(trees=3, leaf=5, negatives=60), Validation(folds=2))


@pytest.fixture(scope="module")
def folder(tmp_path_factory):
    place = tmp_path_factory.mktemp("evaluations")
    saliency_evaluate.run([write_pictures(place / "p", 4)], place / "p.h5", None, PARAMS, Run())
    saliency_evaluate.run([write_surfaces(place / "s", 2)], place / "s.h5", None, PARAMS, Run())
    return place


def test_pictures_are_judged_by_folds_beside_baselines_ceiling_and_features(folder):
    arrays = h5.read(folder / "p.h5", "saliency-evaluation").arrays
    values = dict(zip(arrays["predictors"].tolist(), arrays["values"], strict=True))
    assert set(arrays["roles"]) == {"model", "baseline", "ceiling", "feature"}
    assert values["logistic + boosting"][0] > 0.9
    assert values["centre prior"][1] == pytest.approx(0.5, abs=1e-9)  # equally many fixations in each
    assert "2 folds by picture" in str(arrays["protocol"])
    assert len({name.split("/")[1] for name in arrays if name.startswith("shown/")}) == 2


def test_surfaces_are_judged_by_vertex_and_by_area(folder):
    arrays = h5.read(folder / "s.h5", "saliency-evaluation").arrays
    assert arrays["measures"].tolist() == ["AUC", "AUC by area", "NSS", "CC"]
    values = dict(zip(arrays["predictors"].tolist(), arrays["values"], strict=True))
    assert values["logistic + boosting"][0] > 0.85
    assert "vertex spacing" in values


def test_the_table_beside_it_says_the_same(folder):
    rows = list(csv.DictReader((folder / "p.csv").read_text().splitlines()))
    arrays = h5.read(folder / "p.h5", "saliency-evaluation").arrays
    assert [row["predictor"] for row in rows] == arrays["predictors"].tolist()
    assert float(rows[0]["AUC"]) == pytest.approx(arrays["values"][0, 0], abs=1e-5)
    assert rows[-1]["information gain"] == ""
    assert np.isnan(arrays["values"][-1, 3])


def test_one_picture_alone_is_not_learnt_from(tmp_path):
    saliency_evaluate.run([write_pictures(tmp_path / "p", 1)], tmp_path / "x.h5", None, PARAMS, Run())
    arrays = h5.read(tmp_path / "x.h5", "saliency-evaluation").arrays
    assert "nothing is learnt" in str(arrays["protocol"])
    assert str(arrays["default"]).startswith("Boolean maps")
    assert saliency_evaluate.summary(tmp_path / "x.h5").keys() > {"output", str(arrays["default"])}
