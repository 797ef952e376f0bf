"""Laws of fuse-depth, import-views and merge-depth: what a user may change about the views and what must follow."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from ipcli.cli.main import main
from ipcli.io.files import h5
from ipcli.io.views.artefact import read_views
from tests.fixtures.fusion_scenes import camera, scaled, scene, write

SAMPLE = Path(__file__).parents[2] / "sample_data" / "shapes"
SHAPE = (30, 40)
EXACT = ("--set", "fusion.solver.iterations=150", "--tolerance", "0", "--rounds", "2")


@pytest.fixture(scope="module")
def views():
    return scene(k=5, shape=SHAPE)


@pytest.fixture
def fused(tmp_path):
    """The arrays that fuse-depth makes of these views."""
    made = iter(range(100))

    def run(views, *arguments, **facts):
        folder = tmp_path / str(next(made))
        source = views if isinstance(views, Path) else write(folder / "in.views.h5", views, **facts)
        folder.mkdir(exist_ok=True)
        assert main(["fuse-depth", str(source), "-o", str(folder / "x.h5"), "--quiet", *EXACT, *arguments]) == 0
        return h5.read(folder / "x.h5", "fused-depth").arrays

    return run


@pytest.fixture(scope="module")
def plain(views, tmp_path_factory):
    folder = tmp_path_factory.mktemp("plain")
    source = write(folder / "in.views.h5", views)
    assert main(["fuse-depth", str(source), "-o", str(folder / "x.h5"), "--quiet", *EXACT]) == 0
    return h5.read(folder / "x.h5", "fused-depth").arrays


def close(found, expected, share, tolerance):
    """As many pixels as that agree to the tolerance, relative to the depth; both know the same pixels."""
    known = np.isfinite(expected)
    np.testing.assert_array_equal(np.isfinite(found), known)
    difference = np.abs(found[known] / expected[known] - 1)
    assert np.mean(difference <= tolerance) >= share, np.quantile(difference, [0.5, 0.9, 0.99, 1])


def test_names_of_views_mean_nothing_but_their_order(views, plain, fused):
    found = fused([replace(view, name=f"cam é {'abcde'[n]}") for n, view in enumerate(views)])
    for field in ("depth", "confidence"):
        np.testing.assert_array_equal(found[field], plain[field])
    assert list(found["views"]) == [f"cam é {letter}" for letter in "abcde"]


def test_where_the_world_has_its_origin_and_axes_means_nothing(views, plain, fused):
    move = np.eye(4)
    move[:3, :3], move[:3, 3] = Rotation.from_rotvec((0.4, -1.1, 2.0)).as_matrix(), (3, -7, 11)
    found = fused([replace(view, cam_from_world=view.cam_from_world @ np.linalg.inv(move)) for view in views])
    close(found["depth"], plain["depth"], 0.99, 1e-4)


@pytest.mark.parametrize("factor", [1000.0, 2.0**-4])
def test_another_unit_of_length_gives_the_same_map_in_that_unit(views, plain, fused, factor):
    found = fused([scaled(view, factor) for view in views], unit="mm")
    close(found["depth"] / factor, plain["depth"], 0.99, 1e-4)


def test_a_view_that_saw_nothing_adds_nothing(views, plain, fused):
    """Placed so that the reference stays in the middle."""
    blind = replace(views[-1], name="z", depth=np.full(SHAPE, np.nan, np.float32))
    found = fused([*views, blind], "--reference", "02")
    close(found["depth"], plain["depth"], 0.99, 1e-4)


def test_the_colours_and_the_truth_do_not_touch_the_depth(views, fused):
    """Only a weighting by the edges of the image looks at it; the truth is for errors alone."""
    settings = ("--method", "tv-l1")
    one = fused(views, *settings)["depth"]
    other = fused([replace(view, image=255 - view.image, truth=None) for view in views], *settings)["depth"]
    np.testing.assert_array_equal(one, other)


def test_the_median_of_mirrored_views_is_the_mirror_image_of_the_median(views, fused):
    """A mirror: pixels and the principal point change sides, and x of the world its sign."""
    flip = np.diag([-1.0, 1, 1, 1])
    width, k = SHAPE[1], camera(SHAPE)
    k[0, 2] = width - 1 - k[0, 2]
    mirrored = [
        replace(
            view,
            depth=view.depth[:, ::-1].copy(),
            image=view.image[:, ::-1].copy(),
            truth=view.truth[:, ::-1].copy(),
            intrinsics=k,
            cam_from_world=flip @ view.cam_from_world @ flip,
        )
        for view in views
    ]
    one, other = (fused(sequence, "--method", "median")["depth"] for sequence in (views, mirrored))
    close(other[:, ::-1], one, 0.98, 1e-4)


def test_a_setting_is_the_same_by_option_set_file_and_environment(views, fused, tmp_path, monkeypatch):
    by_option = fused(views, "--lambda", "0.7")
    by_set = fused(views, "--set", "fusion.lam=0.7")
    (tmp_path / "mine.toml").write_text("[fusion]\nlam = 0.7\n")
    by_file = fused(views, "--config", str(tmp_path / "mine.toml"))
    monkeypatch.setenv("IPCLI_FUSION__LAM", "0.7")
    by_environment = fused(views)
    for other in (by_set, by_file, by_environment):
        np.testing.assert_array_equal(other["depth"], by_option["depth"])
        assert float(other["lambda"]) == 0.7


def imported(source, output, *arguments):
    assert main(["import-views", str(source), "-o", str(output), "--quiet", *arguments]) == 0
    return h5.read(output, "views").arrays


def test_an_import_of_an_import_is_the_import(views, tmp_path):
    once = imported(write(tmp_path / "in.h5", views), tmp_path / "once.h5")
    twice = imported(tmp_path / "once.h5", tmp_path / "twice.h5")
    assert set(once) == set(twice)
    for field, array in once.items():
        np.testing.assert_array_equal(twice[field], array)


def test_some_views_are_those_of_all(views, tmp_path):
    source = write(tmp_path / "in.h5", views)
    whole = imported(source, tmp_path / "all.h5", "--noise", "laplace:0.01", "--outliers", "0.1")
    some = imported(source, tmp_path / "some.h5", "--noise", "laplace:0.01", "--outliers", "0.1", "--views", "01,03")
    for name in ("01", "03"):
        np.testing.assert_array_equal(some[f"views/{name}/depth"], whole[f"views/{name}/depth"])
    assert read_views(tmp_path / "some.h5").names == ("01", "03")


def test_what_is_fused_from_a_folder_is_what_is_fused_from_its_import(fused, tmp_path):
    imported(SAMPLE, tmp_path / "in.h5")
    settings = ("--reference", "005", "--window", "3", "--method", "median")
    one, other = (fused(source, *settings) for source in (SAMPLE, tmp_path / "in.h5"))
    for field in ("depth", "confidence"):
        np.testing.assert_array_equal(other[field], one[field])
