"""The page of a model: what it says, what it escapes, that nothing is fetched."""

import numpy as np
import pytest

from ipcli.report.animal import animal_model, surfaces
from ipcli.report.kit.numbers import percent
from tests.fixtures import limbs


@pytest.fixture(scope="module")
def arrays():
    vertices, faces, labels = limbs.mesh(0.06)
    images, cameras = zip(*limbs.shots(("left", "front"), 60), strict=True)
    pictures = {f"pictures/{k:03d}/{key}": i.labels for k, i in enumerate(images) for key in ("labels", "rendered")}
    return pictures | {
        "name": np.array("<ox>"),
        "parts": np.array(limbs.TREE.names),
        "parents": np.array(limbs.TREE.parents, np.int16),
        "vertices": vertices.astype(np.float32),
        "faces": faces.astype(np.int32),
        "face_part": labels - 1,
        "seen_by": (vertices[:, 1] > 0).astype(np.uint16),
        "images": np.array(["left", "front"]),
        "views": np.array(["left", ""]),
        "rotations": np.array([c.rotation for c in cameras]),
        "scales": np.array([c.scale for c in cameras]),
        "shifts": np.array([c.shift for c in cameras]),
        "overlaps": np.array([0.91, 0.87]),
        "part_overlaps": np.array([[0.9, 0.8, 0.7, np.nan], [0.9, 0.8, np.nan, 0.6]]),
        "warnings": np.array(["head in left: 2 blobs"]),
    }


def test_the_page_says_how_well_it_fits_and_what_is_a_guess(arrays):
    html = animal_model.page(arrays, {"digest": "d"})
    assert percent(0.87) in html
    assert "view found from the masks" in html
    assert "head in left: 2 blobs" in html
    assert '<a href="X.turn.html">X.turn.html</a> beside this one' in html
    assert "&lt;ox&gt;" in html
    assert "<ox>" not in html
    assert "<script" not in html
    assert "http" not in html.replace("http://www.w3.org", "")


def test_one_image_one_view_and_a_part_that_is_lost_are_said_so(arrays):
    one = {"images": ["left"], "views": ["left"], "overlaps": [0.91]}
    single = arrays | {key: np.array(values) for key, values in one.items()}
    single |= {key: arrays[key][:1] for key in ("rotations", "scales", "shifts", "part_overlaps")}
    single |= {"face_part": np.where(arrays["face_part"] == 1, 0, arrays["face_part"])}
    html = animal_model.page(single, {"digest": "d"})
    assert "of 3 parts and" in html
    assert "from 1 image; the model shows the right part in 91\N{NO-BREAK SPACE}% of its pixels." in html
    assert "In colour: one image saw it." in html
    assert "1 images" not in html
    assert "Not in the model: head." in html
    assert "■ </b>head" not in html
    assert "■ </b>head" in animal_model.page(arrays, {"digest": "d"})


def test_pictures_show_the_parts_in_their_colours(arrays):
    shown = surfaces.painted_labels(arrays["pictures/000/labels"])
    torso = arrays["pictures/000/labels"] == 1
    assert (shown[torso] == surfaces.colours_of(0)).all()
