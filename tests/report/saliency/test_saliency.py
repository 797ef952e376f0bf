"""The page of saliency."""

import numpy as np
import pytest

from ipcli import report
from ipcli.models.saliency import scene
from ipcli.models.saliency.scene_parameters import Classifying, SceneSaliency, SurfaceFit
from ipcli.report.saliency.saliency import GREEN, RED, marked
from tests.fixtures import search
from tests.fixtures.pages import HOSTILE


@pytest.fixture(scope="module")
def artefact():
    p = SceneSaliency(radius=0.2, surface=SurfaceFit(nodes=900), classifying=Classifying(landmarks=40))
    return scene.saliency(search.sequence(4), p)


def test_the_page_tells_hits_errors_and_worth_and_escapes_notes(artefact, provenance):
    page = report.renderer("saliency")({**artefact, "notes": np.array([HOSTILE])}, provenance)
    assert HOSTILE not in page
    for words in ("by chance", "balanced error rate", "curvature of the surface", "all but membrane", "Elimination"):
        assert words in page


def test_a_page_without_gaze_has_no_table_of_errors(provenance):
    a = scene.saliency(search.sequence(2, gaze=False), SceneSaliency(surface=SurfaceFit(nodes=900)))
    page = report.renderer("saliency")(a, provenance)
    assert "The learnt function</h2>" not in page
    gone = ("by chance", ">looked at<", "Points of regard in red", ">points of regard<", "nodes attended", "–</td>")
    for words in (*gone, "What each score is worth"):
        assert words not in page.partition("<h2>")[2]
    assert "What was predicted</h2>" in page


def test_regards_are_red_and_predicted_patches_green(artefact):
    before = artefact["pictures/images"].copy()
    image = marked(artefact, 0)
    assert (artefact["pictures/images"] == before).all()
    bare = marked(artefact | {"outlines/picture": np.full_like(artefact["outlines/picture"], -1)}, 0)
    assert (artefact["pictures/images"] == before).all()
    assert (bare != image).any()
    colours = {tuple(pixel) for pixel in image.reshape(-1, 3).tolist()}
    assert RED in colours
    assert GREEN in colours
    assert (artefact["pictures/images"][0] != image).any()
