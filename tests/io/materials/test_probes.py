"""Light probes: two to one, finite, not dark."""

import numpy as np
import pytest

from ipcli.errors import FormatError
from ipcli.io.materials import probes


def test_a_probe_comes_back(tmp_path):
    image = np.random.default_rng(0).uniform(0, 9, (8, 16, 3)).astype(np.float32)
    np.save(tmp_path / "p.npy", image)
    np.testing.assert_allclose(probes.read(tmp_path / "p.npy"), image)


def test_radiance_hdr_is_read_as_rgb(tmp_path):
    cv2 = pytest.importorskip("cv2")
    image = np.zeros((8, 16, 3), np.float32)
    image[..., 0] = 4.0
    cv2.imwrite(str(tmp_path / "p.hdr"), image[..., ::-1])
    read = probes.read(tmp_path / "p.hdr")
    assert read[0, 0] == pytest.approx([4, 0, 0], abs=0.05)


@pytest.mark.parametrize(
    "bad", [np.zeros((8, 16, 3)), np.ones((8, 8, 3)), np.full((8, 16, 3), np.nan), np.ones((8, 16, 3), int)]
)
def test_what_is_no_probe_is_refused(tmp_path, bad):
    np.save(tmp_path / "p.npy", bad)
    with pytest.raises(FormatError):
        probes.read(tmp_path / "p.npy")
