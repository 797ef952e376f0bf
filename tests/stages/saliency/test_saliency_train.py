"""saliency-train and what its model is good for: the three commands in a row, on pictures and on surfaces."""

from pathlib import Path

import numpy as np
import pytest

from ipcli.cli.main import main
from ipcli.io.files import h5, images, ply
from ipcli.stages.saliency import saliency_train
from tests.fixtures.fixation_sets import QUICK, bumpy, picture, write_pictures, write_surfaces


@pytest.fixture(scope="module")
def place(tmp_path_factory) -> Path:
    folder = tmp_path_factory.mktemp("models")
    write_pictures(folder / "pictures", 3)
    write_surfaces(folder / "surfaces", 2)
    for name in ("pictures", "surfaces"):
        assert main(["saliency-train", str(folder / name), "-o", str(folder / f"{name}.h5"), "-q", *QUICK]) == 0
    return folder


def test_a_model_holds_no_pickle_and_says_what_it_was_learnt_from(place):
    arrays = h5.read(place / "pictures.h5", "saliency-model").arrays
    assert arrays["items"].tolist() == ["p0", "p1", "p2"]
    assert int(arrays["fixations"]) == 72
    assert len(arrays["trees/feature"]) == 3
    assert saliency_train.summary(place / "pictures.h5")["learnt from"] == "3 pictures, 72 fixations"
    assert saliency_train.summary(place / "surfaces.h5")["learnt from"].endswith(" labelled vertices")


def test_a_picture_that_was_not_learnt_from_is_bright_where_its_disc_is(place):
    canvas, (x, y) = picture(40)
    images.write_png(place / "new.png", canvas)
    words = [str(place / "new.png"), "--model", str(place / "pictures.h5"), "-o", str(place / "new.h5"), "-q"]
    assert main(["saliency-predict", *words]) == 0
    grey = images.read_image(place / "new.new.png")[..., 0].astype(float)
    assert grey.shape == canvas.shape[:2]
    assert grey[y, x] > 2 * grey.mean()


def test_a_cloud_is_bright_on_its_bump(place):
    points, normals, bump = bumpy(9)
    ply.write(place / "ball.ply", points.astype(np.float32), normals=normals.astype(np.float32))
    words = [str(place / "ball.ply"), "--model", str(place / "surfaces.h5"), "-o", str(place / "ball.h5"), "-q"]
    assert main(["saliency-predict", *words]) == 0
    found = ply.read(place / "ball.ball.ply").extra["saliency"]
    assert found[bump > 0.8].mean() > 2 * found.mean()


def test_a_model_of_surfaces_is_refused_for_pictures(place, capsys):
    words = [str(place / "pictures"), "--model", str(place / "surfaces.h5"), "-o", str(place / "no.h5")]
    assert main(["saliency-predict", *words]) == 1
    assert "was not learnt from pictures" in capsys.readouterr().err


def test_judging_a_model_by_what_it_was_learnt_from_is_said(place):
    out = place / "own.h5"
    words = [str(place / "pictures"), "--model", str(place / "pictures.h5"), "-o", str(out), "-q"]
    assert main(["saliency-evaluate", *words]) == 0
    arrays = h5.read(out, "saliency-evaluation").arrays
    assert "learnt from 3 of 3" in arrays["notes"][0]
    assert arrays["predictors"][0] == "pictures.h5"
