"""Recordings of every layout, from folders written here; what is wrong with one is named."""

import re

import numpy as np
import pytest

from experiments.gaze import room
from ipcli.errors import FormatError, ParameterError
from ipcli.io.files import images
from ipcli.io.gaze import layouts, trajectories
from ipcli.measurements.recording import window

TINY = room.Course(frames=3, width=64, height=48, gaze_rate=30.0)


@pytest.fixture(scope="module")
def walked():
    return room.walk(TINY, 1)


def test_an_euroc_folder_comes_back_as_it_was(tmp_path, walked):
    room.write_euroc(walked, tmp_path)
    found = layouts.open_recording(tmp_path)
    assert found.source == "EuRoC/ASL"
    assert np.allclose(np.diff(found.times), np.diff(walked.recording.times), atol=1e-6)
    assert np.allclose(found.truth, walked.recording.truth, atol=1e-6)
    for camera, expected in zip(found.cameras, walked.recording.cameras, strict=True):
        assert np.allclose(camera.intrinsics, expected.intrinsics)
        assert np.allclose(camera.cam_from_rig, expected.cam_from_rig, atol=1e-9)
        assert np.allclose(camera.distortion, expected.distortion)
    frame = found.load(1)
    assert (frame.left == walked.recording.load(1).left).all()
    assert (frame.right == walked.recording.load(1).right).all()


def test_the_layout_of_the_data_set_itself(tmp_path, walked):
    room.write_euroc(walked, tmp_path / "flat")
    for camera in range(2):
        place = tmp_path / "mav0" / f"cam{camera}"
        (place / "data").mkdir(parents=True)
        (tmp_path / "flat" / f"cam{camera}_sensor.yaml").rename(place / "sensor.yaml")
        for path in (tmp_path / "flat" / f"cam{camera}").iterdir():
            path.rename(place / "data" / path.name)
    assert len(layouts.open_recording(tmp_path).names) == 3


def test_imu_samples_come_along_the_axes_of_the_rig(tmp_path, walked):
    room.write_euroc(walked, tmp_path)
    sensor = tmp_path / "cam0_sensor.yaml"
    body_from_cam = "0, 0, 1, 0, -1, 0, 0, 0, 0, -1, 0, 0, 0, 0, 0, 1"  # z ahead is x of the body, x right is its -y
    sensor.write_text(re.sub(r"data: \[.*\]", f"data: [{body_from_cam}]", sensor.read_text()))
    (tmp_path / "imu0").mkdir()
    table = tmp_path / "imu0" / "data.csv"
    table.write_text("#timestamp [ns],w x,w y,w z,a x,a y,a z\n1000000000,.1,.2,.3,1,2,9.8\n1005000000,0,0,0,0,0,9.8\n")
    found = layouts.open_recording(tmp_path)
    np.testing.assert_allclose(found.imu[0], [1.0, -0.2, -0.3, 0.1, -2, -9.8, 1])
    assert found.imu[1, 0] == pytest.approx(1.005)
    assert table in found.files
    table.write_text("1000000000,.1,.2\n")
    with pytest.raises(FormatError, match="cut or too long"):
        layouts.open_recording(tmp_path)


def test_a_vrs_file_is_told_how_to_come(tmp_path):
    (tmp_path / "a.vrs").write_bytes(b"VRS")
    with pytest.raises(FormatError, match="projectaria-tools"):
        layouts.open_recording(tmp_path / "a.vrs")


def test_pictures_of_another_size_than_calibrated_are_refused(tmp_path, walked):
    room.write_euroc(walked, tmp_path)
    first = sorted((tmp_path / "cam0").iterdir())[0]
    images.write_png(first, np.zeros((20, 30), np.uint8))
    with pytest.raises(FormatError, match="another size than its calibration"):
        layouts.open_recording(tmp_path)


def test_pictures_without_a_partner_are_told(tmp_path, walked):
    room.write_euroc(walked, tmp_path)
    sorted((tmp_path / "cam1").iterdir())[2].unlink()
    found = layouts.open_recording(tmp_path)
    assert len(found.names) == 2
    assert "1 pictures have no partner" in found.dropped[0]


def kitti(folder, baseline=-50.0):
    for name in ("image_0", "image_1"):
        for k in range(2):
            images.write_png(folder / name / f"{k:06d}.png", np.full((8, 10), 9, np.uint8))
    rows = [f"P{c}: 100 0 4 {baseline * c} 0 100 4 0 0 0 1 0" for c in (0, 1)]
    (folder / "calib.txt").write_text("\n".join([*rows, "Tr: 1 0 0 0 0 1 0 0 0 0 1 0"]) + "\n")
    return folder


def test_kitti(tmp_path):
    found = layouts.open_recording(kitti(tmp_path))
    assert found.source == "KITTI odometry"
    assert found.cameras[1].cam_from_rig[0, 3] == -0.5


def test_exchanged_projection_matrices_are_refused(tmp_path):
    with pytest.raises(FormatError, match="not to the right"):
        layouts.open_recording(kitti(tmp_path, baseline=50.0))


def test_poses_that_are_not_one_a_frame_are_refused(tmp_path):
    kitti(tmp_path)
    (tmp_path / "poses.txt").write_text("1 0 0 0 0 1 0 0 0 0 1 0\n")
    with pytest.raises(FormatError, match="not one pose a frame"):
        layouts.open_recording(tmp_path)


def test_seven_scenes_has_depth_and_one_camera(tmp_path):
    images.write_png(tmp_path / "frame-000000.color.png", np.full((480, 640, 3), (10, 20, 30), np.uint8))
    images.write_depth_png16(tmp_path / "frame-000000.depth.png", np.full((480, 640), 1.5, np.float32), 1000.0)
    np.savetxt(tmp_path / "frame-000000.pose.txt", np.eye(4))
    found = layouts.open_recording(tmp_path)
    frame = found.load(0)
    assert not found.is_stereo
    assert (frame.depth == 1.5).all()
    assert frame.colour is not None


def test_tum_asks_for_its_calibration(tmp_path):
    (tmp_path / "rgb.txt").write_text("1.0 a.png\n")
    (tmp_path / "depth.txt").write_text("1.0 b.png\n")
    with pytest.raises(ParameterError, match="--intrinsics"):
        layouts.open_recording(tmp_path)


def test_a_trajectory_comes_back_and_is_interpolated(tmp_path, walked):
    truth, times = walked.recording.truth, walked.recording.times
    lost = truth.copy()
    lost[1] = np.nan
    (tmp_path / "a.tum").write_text(trajectories.write_tum(times, lost, "test"))
    stamps, poses = trajectories.read_tum(tmp_path / "a.tum")
    assert len(stamps) == 2
    assert np.allclose(poses[1], truth[2], atol=1e-7)
    between = trajectories.at_times(times, truth, np.array([times[0], (times[0] + times[1]) / 2, 99.0]), 1.0)
    assert np.allclose(between[0], truth[0])
    assert np.allclose(between[1][:3, 3], (truth[0] + truth[1])[:3, 3] / 2)
    assert np.isnan(between[2]).all()


def test_evo_reads_the_trajectory(tmp_path, walked):
    evo = pytest.importorskip("evo.tools.file_interface")
    text = trajectories.write_tum(walked.recording.times, walked.recording.truth, "test")
    (tmp_path / "a.tum").write_text(text)
    found = evo.read_tum_trajectory_file(str(tmp_path / "a.tum"))
    assert np.allclose(found.positions_xyz, walked.recording.truth[:, :3, 3], atol=1e-6)


def test_a_window_keeps_names_times_and_truth_together(walked):
    part = window(walked.recording, 1, 3)
    assert part.names == ("00001", "00002")
    assert (part.load(0).left == walked.recording.load(1).left).all()
    assert (part.truth == walked.recording.truth[1:]).all()


def test_boofcv(tmp_path):
    camera = "<cx>5</cx><cy>4</cy><fx>20</fx><fy>20</fy><height>8</height><width>10</width>"
    camera += "<radial><double>-0.3</double><double>0.1</double></radial>"
    numbers = "".join(f"<double>{value}</double>" for value in np.eye(3).ravel())
    pose = f"<rightToLeft><r><data>{numbers}</data></r><t><x>0.12</x><y>0</y><z>0</z></t></rightToLeft>"
    text = f"<p><left>{camera}</left><right>{camera}</right>{pose}</p>\n"
    (tmp_path / "stereo_params.xml").write_text(text)
    for side in ("left", "right"):
        for k in (2, 10):
            images.write_png(tmp_path / side / f"{side}{k}.png", np.full((8, 10), k, np.uint8))
    found = layouts.open_recording(tmp_path)
    assert found.names == ("02", "10")
    assert found.cameras[1].cam_from_rig[0, 3] == -0.12
    assert found.load(1).left[0, 0] == 10
