"""The command on a small task: what it writes, and that a second recording takes what was learnt."""

import json

import numpy as np
import pytest

from ipcli.cli.main import main
from ipcli.io.files import h5, ply
from tests.fixtures import search

QUICK = ("--nodes", "900", "--set", "scene.group_size=0", "--set", "scene.classifying.landmarks=40")


@pytest.fixture(scope="module")
def made(tmp_path_factory):
    folder = tmp_path_factory.mktemp("search")
    source = search.write(folder / "run.gaze.h5")
    assert main(["saliency", str(source), "-o", str(folder / "x.h5"), *QUICK]) == 0
    return folder


def test_the_cloud_has_saliency_and_a_colour_for_each_point(made):
    a = h5.read(made / "x.h5", "saliency").arrays
    cloud = ply.read(made / "x.ply")
    assert len(cloud.vertices) == len(a["points/places"])
    assert cloud.extra["saliency"] == pytest.approx(a["points/saliency"])


def test_proto_objects_are_a_table(made):
    lines = (made / "x.objects.csv").read_text().splitlines()
    a = h5.read(made / "x.h5", "saliency").arrays
    assert len(lines) == 1 + len(a["objects/track"])
    assert lines[0].startswith("x [m],y [m],z [m]")


def test_figures_are_told_as_json(made, capsys):
    line = ["saliency", str(made / "run.gaze.h5"), "-o", str(made / "x.h5"), *QUICK, "--json"]
    assert main(line) == 0
    facts = json.loads(capsys.readouterr().out)
    assert facts["output"].endswith("x.h5")
    assert facts["subsequences"] == len(search.experiment()["subsequences/frames"])


def test_what_was_learnt_is_applied_to_another_recording(made):
    line = ["saliency", str(made / "run.gaze.h5"), "-o", str(made / "y.h5"), *QUICK, "--model", str(made / "x.h5")]
    assert main(line) == 0
    a = h5.read(made / "y.h5", "saliency").arrays
    assert "model/columns" not in a
    assert np.isfinite(a["points/saliency"]).all()


def test_a_result_in_which_nothing_was_learnt_is_no_model(made, capsys):
    assert main(["saliency", str(made / "run.gaze.h5"), "-o", str(made / "z.h5"), "--model", str(made / "y.h5")]) == 1
    assert "nothing was learnt" in capsys.readouterr().err
