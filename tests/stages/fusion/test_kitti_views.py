from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from ipcli.errors import ParameterError
from ipcli.executor import ItemsFailed
from ipcli.geometry.cameras import back_project, project, transform
from ipcli.io.files import images, npz
from ipcli.io.views import layouts
from ipcli.measurements.views import relative
from ipcli.params import Run
from ipcli.stages.fusion import kitti_views
from ipcli.stages.fusion.parameters import KittiViews, Sgbm
from ipcli.stages.kit.artefact import Outcome

FOCAL, BASELINE, DISPARITY = 100.0, 0.5, 10  # a wall at 5 m
SMALL = KittiViews(sgbm=Sgbm(disparities=16))


@pytest.fixture
def scenes(tmp_path) -> Path:
    """Scenes 0 (frames 10, 11) and 2 (frame 10) of a textured wall, with truth, calibration and poses."""
    rng = np.random.default_rng(1)
    wall = rng.integers(0, 256, (40, 100 + DISPARITY), dtype=np.uint8)
    for name in ("000000_10", "000000_11", "000002_10"):
        images.write_png(tmp_path / "image_0" / f"{name}.png", wall[:, :100])
        images.write_png(tmp_path / "image_1" / f"{name}.png", wall[:, DISPARITY:])
    for kind, value in (("disp_noc", 10.0), ("disp_occ", 12.5)):
        images.write_depth_png16(tmp_path / kind / "000000_10.png", np.full((40, 100), value), 256)
    (tmp_path / "calib").mkdir()
    for scene in ("000000", "000002"):
        rows = [f"P{i}: {FOCAL} 0 50 {-i * FOCAL * BASELINE} 0 {FOCAL} 20 0 0 0 1 0\n" for i in range(2)]
        (tmp_path / "calib" / f"{scene}.txt").write_text("".join(rows))
    table = np.tile(np.eye(4), (3, 21, 1, 1))
    table[0, 11, 2, 3] = 1.0  # one metre forward
    npz.write(tmp_path / "poses.npz", {"viso": table, "gm": table})
    return tmp_path


def run(scenes: Path, params: KittiViews = SMALL, how: Run = Run()) -> dict[Path, Outcome]:
    return kitti_views.run(scenes, scenes / "poses.npz", scenes / "out", params, how)


def test_each_scene_becomes_views_of_both_cameras_with_poses_and_truth(scenes):
    outcomes = run(scenes)
    assert outcomes == {scenes / "out" / f"{scene}.views.h5": Outcome.DONE for scene in ("000000", "000002")}
    sequence = layouts.open_views(scenes / "out" / "000000.views.h5")
    assert sequence.names == ("10_left", "10_right", "11_left", "11_right")
    assert (sequence.unit, sequence.measured, sequence.baseline_focal) == ("m", "disparity", FOCAL * BASELINE)
    left, right, later = (sequence.load(name) for name in sequence.names[:3])
    for view in (left, right):
        assert np.nanmedian(view.depth) == pytest.approx(FOCAL * BASELINE / DISPARITY, rel=0.01)
        assert np.isfinite(view.depth).mean() > 0.75
    np.testing.assert_allclose(relative(right, left)[:3, 3], [-BASELINE, 0, 0], atol=1e-9)
    np.testing.assert_allclose(relative(later, left)[:3, 3], [0, 0, -1], atol=1e-9)
    np.testing.assert_allclose(left.truth, 5.0)
    assert right.truth is None
    assert later.truth is None


def test_truth_may_include_what_the_right_camera_does_not_see(scenes):
    run(scenes, KittiViews(scenes="0", truth="occ", sgbm=SMALL.sgbm))
    np.testing.assert_allclose(layouts.open_views(scenes / "out" / "000000.views.h5").load("10_left").truth, 4.0)


def test_a_second_run_does_nothing_and_other_parameters_do_not_replace(scenes):
    run(scenes)
    before = (scenes / "out" / "000000.views.h5").read_bytes()
    assert set(run(scenes).values()) == {Outcome.UP_TO_DATE}
    other = KittiViews(sgbm=Sgbm(disparities=16, block=3))
    with pytest.raises(ItemsFailed, match="2 of 2 items failed.*--overwrite"):
        run(scenes, other)
    assert (scenes / "out" / "000000.views.h5").read_bytes() == before
    assert set(run(scenes, other, Run(overwrite=True)).values()) == {Outcome.DONE}


def test_a_scene_is_the_same_alone_among_others_and_in_a_pool(scenes):
    path = scenes / "out" / "000000.views.h5"
    run(scenes, replace(SMALL, scenes="0"))
    alone = path.read_bytes()
    assert list(run(scenes).values()) == [Outcome.UP_TO_DATE, Outcome.DONE]
    path.unlink()
    run(scenes, SMALL, Run(executor="processes:2"))
    assert path.read_bytes() == alone


def test_a_scene_that_fails_does_not_stop_the_others_and_a_rerun_does_it_alone(scenes):
    calibration = scenes / "calib" / "000000.txt"
    text = calibration.read_text()
    calibration.write_text("P0: 1 2\n")
    with pytest.raises(ItemsFailed, match=r"1 of 2 items failed .000000: .*000000\.txt: line 1 is cut"):
        run(scenes)
    calibration.write_text(text)
    assert [outcome for _, outcome in sorted(run(scenes).items())] == [Outcome.DONE, Outcome.UP_TO_DATE]


def test_scenes_are_chosen_by_number(scenes):
    assert kitti_views.select_scenes(scenes, "2,000000") == ("000002", "000000")
    with pytest.raises(ParameterError, match="no scene '000001' among the 2"):
        kitti_views.select_scenes(scenes, "1")


def test_settings_that_the_matcher_would_refuse_and_missing_poses_are_refused_first(scenes):
    for sgbm in (Sgbm(disparities=20), Sgbm(block=4)):
        with pytest.raises(ParameterError, match="multiple of 16, and sgbm.block odd"):
            run(scenes, KittiViews(sgbm=sgbm))
    npz.write(scenes / "poses.npz", {"viso": np.full((3, 21, 4, 4), np.nan)})
    with pytest.raises(ItemsFailed, match="no pose of any frame of scene 000000 .expected frames 10, 11, got none"):
        run(scenes)


@pytest.mark.real
def test_real_scene_matches_its_truth_and_the_right_camera_confirms_the_left(real_data, tmp_path):
    poses = real_data("fusion/kitti2012_poses") / "poses_training_cam2world.npz"
    kitti_views.run(
        real_data("fusion/kitti2012_multiview"), poses, tmp_path, KittiViews(scenes="138", truth="occ"), Run()
    )
    sequence = layouts.open_views(tmp_path / "000138.views.h5")
    left, right, later = (sequence.load(name) for name in sequence.names[:3])
    bf = sequence.baseline_focal
    error = bf / left.depth - bf / left.truth
    error = error[np.isfinite(error)]
    assert len(error) > 0.7 * np.isfinite(left.truth).sum()
    assert np.median(np.abs(error)) < 0.5
    assert abs(np.median(error)) < 0.2
    assert np.mean(np.abs(error) > 3) < 0.08

    for other in (right, later):  # carried into the left view, their disparities are those of the left view
        points = transform(relative(left, other), back_project(other.depth, other.intrinsics)).reshape(-1, 3)
        pixels = np.rint(project(points, left.intrinsics))
        inside = ((pixels >= 0) & (pixels < left.depth.shape[::-1])).all(axis=1)
        u, v = pixels[inside].astype(int).T
        difference = bf / points[inside, 2] - bf / left.depth[v, u]
        assert np.nanmedian(np.abs(difference)) < 1.0
