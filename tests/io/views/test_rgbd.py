from __future__ import annotations

import json
from pathlib import Path

import numpy as np
import pytest

from ipcli.errors import FormatError, ParameterError
from ipcli.io.files import images
from ipcli.io.views import rgbd

CAMERA = (52.0, 50.0, 15.5, 11.5)


def text(matrix: np.ndarray) -> str:
    return "\n".join(" ".join(f"{value:.12f}" for value in row) for row in matrix)


def quaternion(rotation: np.ndarray) -> np.ndarray:
    """x y z w, by SciPy: not the formula under test."""
    from scipy.spatial.transform import Rotation

    return Rotation.from_matrix(rotation).as_quat()


@pytest.fixture
def tum(tmp_path, views) -> Path:
    """Depth at times 10.00, 10.10, 10.20 s; colour 5 ms and poses 8 ms later; one depth image more without a pose."""
    folder = tmp_path / "recording"
    index = {name: ["# a comment"] for name in ("depth", "rgb", "groundtruth")}
    for number, view in enumerate(views):
        time = 10 + number / 10
        images.write_depth_png16(folder / "depth" / f"{time:.2f}.png", view.depth, 5000)
        images.write_png(folder / "rgb" / f"{time:.2f}.png", view.image)
        index["depth"].append(f"{time:.6f} depth/{time:.2f}.png")
        index["rgb"].append(f"{time + 0.005:.6f} rgb/{time:.2f}.png")
        pose = np.linalg.inv(view.cam_from_world)
        numbers = (time + 0.008, *pose[:3, 3], *quaternion(pose[:3, :3]))
        index["groundtruth"].append(" ".join(f"{value:.12f}" for value in numbers))
    index["depth"].append("99.000000 depth/99.png")
    for name, lines in index.items():
        (folder / f"{name}.txt").write_text("\n".join(lines))
    return folder


def test_tum_frames_get_the_pose_and_the_colour_nearest_in_time(tum, views, same):
    sequence = rgbd.open_tum(tum, intrinsics=CAMERA)
    assert sequence.names == ("10.00", "10.10", "10.20")
    assert (sequence.unit, sequence.measured) == ("m", "depth")
    for name, view in zip(sequence.names, views, strict=True):
        same(sequence.load(name), view)
    assert sequence.files("10.10") == (tum / "depth/10.10.png", tum / "rgb/10.10.png", tum / "groundtruth.txt")


def test_tum_intrinsics_follow_from_the_name_of_the_folder_or_must_be_given(tum):
    with pytest.raises(ParameterError, match=r"intrinsics unknown.*525,525,319\.5,239\.5 is the ROS default"):
        rgbd.open_tum(tum)
    named = tum.rename(tum.with_name("rgbd_dataset_freiburg3_office"))
    sequence = rgbd.open_tum(named)
    assert sequence.load(sequence.names[0]).intrinsics[0, 0] == 535.4


def test_tum_without_colour_is_read_all_the_same(tum):
    (tum / "rgb.txt").unlink()
    assert rgbd.open_tum(tum, intrinsics=CAMERA).load("10.00").image is None


def test_tum_clocks_that_disagree_are_an_error(tum):
    with pytest.raises(
        FormatError, match=r"groundtruth.txt: none of 4 depth images has a pose within 0\.001 s.*max_gap"
    ):
        rgbd.open_tum(tum, intrinsics=CAMERA, max_gap=0.001)


@pytest.mark.parametrize(
    ("file", "line", "message"),
    [
        ("groundtruth.txt", "11.0 1 2 3 0 0 0", "line 5 is cut or too long .expected 8 numbers, got 7"),
        ("groundtruth.txt", "11.0 1 2 3 0 0 0 9", "line 5 has no unit quaternion .*got 9"),
        ("groundtruth.txt", "11.0 1 2 3 0 0 zero 1", "line 5 holds something that is not a number"),
        ("depth.txt", "11.0", "line 6 is cut .*a time and a file name"),
    ],
)
def test_tum_lines_that_cannot_be_read_are_named(tum, file, line, message):
    with (tum / file).open("a") as stream:
        stream.write("\n" + line)
    with pytest.raises(FormatError, match=f"{file}: {message}"):
        rgbd.open_tum(tum, intrinsics=CAMERA)


@pytest.fixture
def open3d(tmp_path, views) -> Path:
    """Frames 9, 10 and 11 in names without leading zeros, and a trajectory of exactly these."""
    lines = []
    for number, view in enumerate(views):
        images.write_depth_png16(tmp_path / "depth" / f"{9 + number}.png", view.depth, 1000)
        images.write_png(tmp_path / "color" / f"{9 + number}.png", view.image)
        lines += [f"{number} {number} {number + 1}", text(np.linalg.inv(view.cam_from_world))]
    (tmp_path / "trajectory.log").write_text("\n".join(lines))
    return tmp_path


def test_open3d_frames_are_in_numerical_order_with_the_poses_of_the_trajectory(open3d, views, same):
    sequence = rgbd.open_open3d(open3d, intrinsics=CAMERA)
    assert sequence.names == ("09", "10", "11") == tuple(sorted(sequence.names))
    for name, view in zip(sequence.names, views, strict=True):
        same(sequence.load(name), view)


def test_open3d_frame_numbers_pick_from_a_longer_trajectory(open3d, views, same):
    lines = (open3d / "trajectory.log").read_text().splitlines()
    blocks = [lines[start : start + 5] for start in range(0, 15, 5)]
    renumbered = [
        ["9 9 10", *blocks[0][1:]],
        ["10 10 11", *blocks[1][1:]],
        ["11 11 12", *blocks[2][1:]],
        ["3 3 4", *blocks[0][1:]],
    ]
    (open3d / "trajectory.log").write_text("\n".join(line for block in renumbered for line in block))
    sequence = rgbd.open_open3d(open3d, intrinsics=CAMERA)
    for name, view in zip(sequence.names, views, strict=True):
        same(sequence.load(name), view)


def test_open3d_frames_without_pose_and_a_cut_trajectory_are_refused(open3d):
    log = open3d / "trajectory.log"
    lines = log.read_text().splitlines()
    log.write_text("\n".join(lines[:10]))
    with pytest.raises(FormatError, match="no pose of 3 of 3 depth images, the first is '9'.*2 frames"):
        rgbd.open_open3d(open3d, intrinsics=CAMERA)
    log.write_text("\n".join(lines[:13]))
    with pytest.raises(
        FormatError, match=r"trajectory.log: not a camera trajectory \(expected blocks of 5 lines, got 13 lines"
    ):
        rgbd.open_open3d(open3d, intrinsics=CAMERA)


def test_open3d_takes_the_camera_of_the_folder_and_the_only_log(open3d, views, same):
    (open3d / "trajectory.log").rename(open3d / "room-traj.log")
    camera = {"width": 32, "height": 24, "intrinsic_matrix": views[0].intrinsics.T.ravel().tolist()}
    (open3d / "camera_intrinsic.json").write_text(json.dumps(camera))
    sequence = rgbd.open_open3d(open3d)
    for name, view in zip(sequence.names, views, strict=True):
        same(sequence.load(name), view)
    (open3d / "other.log").write_text("")
    with pytest.raises(FormatError, match=r"which .log is the trajectory.*other.log, room-traj.log.*source.trajectory"):
        rgbd.open_open3d(open3d)


@pytest.mark.parametrize(
    ("content", "message"),
    [("{", "not a camera of Open3D"), ('{"width": 9, "height": 24, "intrinsic_matrix": [1,0,0,0,1,0,0,0,1]}', "size")],
)
def test_an_open3d_camera_that_cannot_be_right_is_refused(open3d, content, message):
    (open3d / "camera_intrinsic.json").write_text(content)
    with pytest.raises(FormatError, match=f"camera_intrinsic.json: .*{message}"):
        rgbd.open_open3d(open3d)


def test_scannet_frames_come_in_order_and_those_without_pose_are_counted(tmp_path, views, same):
    (tmp_path / "pose").mkdir()
    (tmp_path / "intrinsic").mkdir()
    camera = np.eye(4)
    camera[:3, :3] = views[0].intrinsics
    np.savetxt(tmp_path / "intrinsic" / "intrinsic_depth.txt", camera)
    for number, view in zip((2, 10, 11), views, strict=True):
        images.write_depth_png16(tmp_path / "depth" / f"{number}.png", view.depth, 1000)
        images.write_png(tmp_path / "color" / f"{number}.png", view.image)
        (tmp_path / "pose" / f"{number}.txt").write_text(text(np.linalg.inv(view.cam_from_world)))
    sequence = rgbd.open_scannet(tmp_path)
    assert (sequence.names, sequence.notes) == (("02", "10", "11"), ())
    for name, view in zip(sequence.names, views, strict=True):
        same(sequence.load(name), view)
    (tmp_path / "pose" / "10.txt").write_text(text(np.full((4, 4), -np.inf)))
    sequence = rgbd.open_scannet(tmp_path)
    assert sequence.names == ("02", "11")
    assert sequence.notes == ("1 of 3 depth images left out: no known pose in pose/",)


def test_tum_tables_may_have_tabs_and_images_left_out_are_counted(tum, views, same):
    for name in ("depth.txt", "rgb.txt", "groundtruth.txt"):
        (tum / name).write_text((tum / name).read_text().replace(" ", "\t"))
    whole = rgbd.open_tum(tum, intrinsics=CAMERA)
    before = len(whole.names)
    (tum / "depth.txt").write_text((tum / "depth.txt").read_text() + "\n99999.0\tdepth/none.png\n")
    sequence = rgbd.open_tum(tum, intrinsics=CAMERA)
    assert len(sequence.names) == before
    left = int(sequence.notes[0].split()[0])
    assert left == 1 + (int(whole.notes[0].split()[0]) if whole.notes else 0)


def test_the_primesense_default_is_only_for_its_own_size(open3d):
    with pytest.raises(ParameterError, match=r"640 x 480 and this is 32 x 24\. Give fx,fy,cx,cy"):
        rgbd.open_open3d(open3d)


@pytest.fixture
def seven_scenes(tmp_path, views) -> Path:
    for number, view in enumerate(views):
        stem = tmp_path / f"frame-{number:06d}"
        images.write_depth_png16(stem.with_suffix(".depth.png"), view.depth, 1000)
        images.write_png(stem.with_suffix(".color.png"), view.image)
        stem.with_suffix(".pose.txt").write_text(text(np.linalg.inv(view.cam_from_world)))
    (tmp_path / "camera-intrinsics.txt").write_text(text(views[0].intrinsics))
    return tmp_path


def test_seven_scenes_frames_are_read_with_their_own_intrinsics(seven_scenes, views, same):
    sequence = rgbd.open_seven_scenes(seven_scenes)
    assert sequence.names == ("frame-000000", "frame-000001", "frame-000002")
    for name, view in zip(sequence.names, views, strict=True):
        same(sequence.load(name), view)


def test_seven_scenes_defaults_to_the_published_camera(seven_scenes):
    (seven_scenes / "camera-intrinsics.txt").unlink()
    camera = rgbd.open_seven_scenes(seven_scenes).load("frame-000001").intrinsics
    np.testing.assert_array_equal(camera, [[585, 0, 320], [0, 585, 240], [0, 0, 1]])


def test_both_marks_of_missing_depth_become_nan(seven_scenes):
    import cv2

    path = seven_scenes / "frame-000001.depth.png"
    stored = cv2.imread(str(path), cv2.IMREAD_UNCHANGED)
    stored[0, 0], stored[0, 1], stored[0, 2] = 0, 65535, 65534
    cv2.imwrite(str(path), stored)
    depth = rgbd.open_seven_scenes(seven_scenes).load("frame-000001").depth
    assert np.isnan(depth[0, :2]).all()
    assert depth[0, 2] == np.float32(65.534)


def test_a_frame_is_read_only_when_asked_for(seven_scenes):
    (seven_scenes / "frame-000001.pose.txt").unlink()
    (seven_scenes / "frame-000002.depth.png").write_bytes(b"")
    sequence = rgbd.open_seven_scenes(seven_scenes)
    sequence.load("frame-000000")
    with pytest.raises(FormatError, match="frame-000001.pose.txt: no such file"):
        sequence.load("frame-000001")
    with pytest.raises(FormatError, match="frame-000002.depth.png: "):
        sequence.load("frame-000002")


@pytest.mark.parametrize(
    ("pose", "message"),
    [
        (2 * np.eye(4), "view 'frame-000001': pose has a wrong last row"),
        (np.diag([1.0, 1.1, 1.0, 1.0]), "view 'frame-000001': pose is not rigid"),
        (np.zeros((4, 4)), "frame-000001.pose.txt: pose is singular"),
        (np.eye(4)[:3], r"frame-000001.pose.txt: wrong number of rows \(expected 4, got 3\)"),
        (np.diag([np.nan, 1, 1, 1]), "frame-000001.*NaN"),
    ],
)
def test_poses_that_are_none_are_refused_with_file_and_view(seven_scenes, pose, message):
    (seven_scenes / "frame-000001.pose.txt").write_text(text(pose))
    with pytest.raises(FormatError, match=message):
        rgbd.open_seven_scenes(seven_scenes).load("frame-000001")


def test_a_cut_image_is_refused(seven_scenes):
    path = seven_scenes / "frame-000000.depth.png"
    path.write_bytes(path.read_bytes()[:-40])
    with pytest.raises(FormatError, match="frame-000000.depth.png: truncated"):
        rgbd.open_seven_scenes(seven_scenes).load("frame-000000")


def test_colour_of_another_resolution_is_resampled_and_of_other_proportions_refused(seven_scenes, views, same):
    path = seven_scenes / "frame-000000.color.png"
    images.write_png(path, views[0].image.repeat(2, axis=0).repeat(2, axis=1))
    same(rgbd.open_seven_scenes(seven_scenes).load("frame-000000"), views[0])
    images.write_png(path, views[0].image.repeat(2, axis=0))
    with pytest.raises(
        FormatError,
        match=r"color.png: image and depth map differ in proportions \(expected 32 x 24 or a multiple, got 32 x 48\)",
    ):
        rgbd.open_seven_scenes(seven_scenes).load("frame-000000")


def test_a_depth_scale_must_be_positive(seven_scenes):
    with pytest.raises(ParameterError, match="depth_scale = 0: expected a number > 0"):
        rgbd.open_seven_scenes(seven_scenes, depth_scale=0)
