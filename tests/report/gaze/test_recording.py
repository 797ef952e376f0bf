"""The page of a recording tells of its IMU which way is up."""

import numpy as np

from ipcli.report.gaze.recording import page

RECORDING = {
    "names": np.array(["0", "1"]),
    "times": np.array([0.0, 0.5]),
    "rig/sizes": np.array([[64, 48]]),
    "rig/models": np.array(["pinhole"]),
    "rig/intrinsics": np.diag([50.0, 50.0, 1.0])[None],
    "source": np.array("EuRoC/ASL"),
}
PROVENANCE = {"command": "import-recording", "digest": "0" * 16, "parameters": {}, "inputs": {}}


def test_the_imu_tells_its_rate_and_which_way_is_up():
    samples = np.zeros((101, 7))
    samples[:, 0] = np.arange(101) * 0.005
    samples[:, 5] = -9.81  # y points down, so that what carries the head points against it
    html = page(RECORDING | {"imu": samples}, PROVENANCE)
    assert "IMU" in html
    for cell in (">101</th>", "<td>200</td>", "<td>9.81</td>", "<td>0, −1, 0</td>"):
        assert cell in html
    assert "IMU" not in page(RECORDING, PROVENANCE)
