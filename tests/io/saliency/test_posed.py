"""Experiments and views as subsequences."""

import numpy as np
import pytest

from ipcli.errors import FormatError
from ipcli.io.files import h5, ply
from ipcli.io.saliency.posed import open_posed, read_cloud
from ipcli.measurements.subsequences import seen_at
from tests.fixtures import fusion_scenes, search


def test_an_experiment_is_its_subsequences_with_their_points_and_pictures(tmp_path):
    path = search.write(tmp_path / "run.gaze.h5")
    a = search.experiment()
    found = open_posed(path)
    assert found.count == len(a["subsequences/frames"])
    assert len(found.regards) == (a["por/outcome"] == "hit").sum()
    sub = found.load(1)
    first, stop = a["subsequences/frames"][1]
    assert sub.frames == (first, stop)
    assert sub.times == (a["times"][first], a["times"][stop - 1])
    assert all(first <= shot.frame < stop for shot in sub.snapshots)
    assert len(sub.regards) == ((a["por/frame"] >= first) & (a["por/frame"] < stop)).sum()
    pixels = seen_at(found.camera, sub.cam_from_world, sub.cloud)
    assert np.isfinite(pixels).all(axis=1).mean() > 0.95  # the map of a subsequence is before its camera


def test_an_experiment_without_a_pose_is_refused(tmp_path):
    a = dict(search.experiment())
    a["world_from_rig"] = np.full_like(a["world_from_rig"], np.nan)
    h5.write(tmp_path / "lost.h5", "gaze-experiment", a, {"command": "test", "params": {}})
    with pytest.raises(FormatError, match="no frame has both"):
        open_posed(tmp_path / "lost.h5")


def test_views_are_runs_of_frames_whose_depth_is_the_cloud(tmp_path):
    views = fusion_scenes.scene(k=3, shape=(24, 32))
    path = fusion_scenes.write(tmp_path / "scene.views.h5", views)
    found = open_posed(path)
    assert found.count == 1
    sub = found.load(0)
    assert sub.frames == (0, 3)
    assert len(found.regards) == 0
    pixels = seen_at(found.camera, sub.cam_from_world, sub.cloud)
    assert np.isfinite(pixels).all(axis=1).mean() > 0.7
    assert "numbers of frames" in found.notes[0]


def test_a_cloud_is_read_from_a_ply(tmp_path):
    points = np.random.default_rng(0).normal(size=(5, 3)).astype(np.float32)
    ply.write(tmp_path / "c.ply", points)
    assert read_cloud(tmp_path / "c.ply") == pytest.approx(points)


def test_anything_else_is_a_format_error(tmp_path):
    with pytest.raises(FormatError):
        open_posed(tmp_path / "nothing")


@pytest.mark.parametrize("name", ["photo.jpg", "cow.ply"])
def test_a_picture_or_mesh_is_sent_to_the_command_for_it(tmp_path, name):
    (tmp_path / name).write_bytes(b"x")
    with pytest.raises(FormatError, match="saliency predict"):
        open_posed(tmp_path / name)
