from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

from ipcli.errors import FormatError
from ipcli.io.files import images, npz
from ipcli.io.views import kitti

FOCAL, BASELINE = 700.0, 0.54
P0 = np.array([[FOCAL, 0, 20, 0], [0, FOCAL, 10, 0], [0, 0, 1, 0]])
P1, P2, P3 = (P0 + np.outer([1, 0, 0], [0, 0, 0, shift * FOCAL]) for shift in (-BASELINE, 0.06, 0.06 - BASELINE))


def calibration_text(*names: str) -> str:
    matrices = {"P0": P0, "P1": P1, "P2": P2, "P3": P3}
    return "".join(f"{name}: {' '.join(f'{value:.6e}' for value in matrices[name].ravel())}\n" for name in names)


@pytest.fixture
def folder(tmp_path) -> Path:
    """Scenes 3 (frames 10, 11; 12 only on the left) and 7 (frame 10), gray."""
    for side in "01":
        for name in ("000003_10", "000003_11", "000007_10", *(["000003_12"] if side == "0" else [])):
            images.write_png(tmp_path / f"image_{side}" / f"{name}.png", np.full((20, 40), 100 + int(side), np.uint8))
    (tmp_path / "calib").mkdir()
    (tmp_path / "calib" / "000003.txt").write_text(calibration_text("P0", "P1"))
    return tmp_path


def test_scenes_and_frames_are_those_with_both_images(folder):
    assert kitti.scenes(folder) == ("000003", "000007")
    assert kitti.frames(folder, "000003") == ("10", "11")
    left, right = kitti.pair(folder, "000003", "11")
    assert left.shape == (20, 40, 3)
    assert (left.max(), right.min()) == (100, 101)
    with pytest.raises(FormatError, match="no stereo pair of scene '000004'.*Scenes here: 000003, 000007"):
        kitti.frames(folder, "000004")


def test_a_folder_without_images_and_a_pair_of_two_sizes_are_refused(folder, tmp_path):
    with pytest.raises(FormatError, match="not a KITTI stereo folder .*image_0/ or colored_0/"):
        kitti.scenes(folder / "calib")
    images.write_png(tmp_path / "image_1" / "000003_10.png", np.zeros((20, 41), np.uint8))
    with pytest.raises(
        FormatError, match=r"image_1/000003_10.png: right image differs in size from the left \(expected \(20, 40, 3\)"
    ):
        kitti.pair(folder, "000003", "10")


def test_gray_cameras_come_from_p0_and_p1(folder):
    camera = kitti.calibration(folder, "000003")
    np.testing.assert_allclose(camera.intrinsics, P0[:, :3])
    assert camera.baseline_focal == pytest.approx(-P1[0, 3])
    np.testing.assert_allclose(camera.left_from_cam0, np.eye(4))
    np.testing.assert_allclose(camera.right_from_cam0[:3, 3], [-BASELINE, 0, 0], atol=1e-6)


def test_colour_cameras_come_from_p2_and_p3_and_are_shifted_against_the_poses(folder):
    for side in "01":
        (folder / f"image_{side}").rename(folder / f"colored_{side}")
    with pytest.raises(FormatError, match=r"000003.txt: no projection matrix P2 \(expected P2 and P3, got P0, P1\)"):
        kitti.calibration(folder, "000003")
    (folder / "calib" / "000003.txt").write_text(calibration_text("P0", "P1", "P2", "P3"))
    camera = kitti.calibration(folder, "000003")
    assert camera.left_from_cam0[0, 3] == pytest.approx(0.06, rel=1e-5)
    assert camera.baseline_focal == pytest.approx(BASELINE * FOCAL, rel=1e-5)
    point = np.array([1.0, 2.0, 9.0, 1.0])  # seen by P2 where it projects to in the shifted camera
    np.testing.assert_allclose(P2 @ point, camera.intrinsics @ (camera.left_from_cam0 @ point)[:3], rtol=1e-5)


@pytest.mark.parametrize(
    ("text", "message"),
    [
        ("P0: 1 2 3\n", "line 1 is cut or too long .expected 12 numbers, got 3"),
        (calibration_text("P0"), "no projection matrix P1"),
        (
            calibration_text("P0", "P1").replace("P0", "PX").replace("P1", "P0").replace("PX", "P1"),
            "baseline is not positive.*Swap",
        ),
    ],
)
def test_calibration_that_cannot_be_used_is_refused(folder, text, message):
    (folder / "calib" / "000003.txt").write_text(text)
    with pytest.raises(FormatError, match=f"000003.txt: {message}"):
        kitti.calibration(folder, "000003")


def test_truth_is_disparity_with_gaps(folder):
    disparity = np.full((20, 40), np.nan)
    disparity[5, 6] = 12.5
    images.write_depth_png16(folder / "disp_noc" / "000003_10.png", disparity, 256)
    np.testing.assert_array_equal(kitti.truth(folder, "000003"), disparity)
    with pytest.raises(FormatError, match="disp_occ"):
        kitti.truth(folder, "000003", occluded=True)


def test_poses_come_from_a_table_of_all_scenes_without_the_frames_it_lacks(tmp_path):
    table = np.full((8, 21, 4, 4), np.nan)
    table[3, 7:12] = np.eye(4)
    table[3, 8, 0, 3] = 2.5
    npz.write(tmp_path / "poses.npz", {"viso": table, "gm": table + 1})
    poses = kitti.poses(tmp_path / "poses.npz", "000003")
    assert list(poses) == ["07", "08", "09", "10", "11"]
    assert poses["08"][0, 3] == 2.5
    with pytest.raises(FormatError, match="no poses by 'orb' .expected one of gm, viso"):
        kitti.poses(tmp_path / "poses.npz", "000003", "orb")
    with pytest.raises(FormatError, match="no poses of scene '000008' .expected a number below 8"):
        kitti.poses(tmp_path / "poses.npz", "000008")
    npz.write(tmp_path / "flat.npz", {"viso": table[0]})
    with pytest.raises(FormatError, match="is not a table of poses"):
        kitti.poses(tmp_path / "flat.npz", "000003")


def test_poses_come_from_odometry_text_of_one_scene_or_a_folder_of_scenes(tmp_path):
    lines = [" ".join(f"{value:g}" for value in (1, 0, 0, frame, 0, 1, 0, 0, 0, 0, 1, 0)) for frame in range(3)]
    (tmp_path / "000003.txt").write_text("\n".join(lines))
    for path in (tmp_path, tmp_path / "000003.txt"):
        poses = kitti.poses(path, "000003")
        assert list(poses) == ["00", "01", "02"]
        np.testing.assert_array_equal(poses["02"], [[1, 0, 0, 2], [0, 1, 0, 0], [0, 0, 1, 0], [0, 0, 0, 1]])
    with pytest.raises(FormatError, match="000004.txt: no such file"):
        kitti.poses(tmp_path, "000004")
