"""C3D markers as ezc3d writes them; what is lost is unknown; what cannot be read is said."""

from __future__ import annotations

import sys

import numpy as np
import pytest

from ipcli.errors import FormatError, IpcliError
from ipcli.io.motion import c3d

ezc3d = pytest.importorskip("ezc3d")


@pytest.fixture
def written(tmp_path):
    """A file of two markers over three frames, in millimetres at 50 Hz; the second marker is lost in frame 1."""

    def write(labels=("LFHD", " C7 "), unit="mm", points=None):
        points = 1000 * np.arange(1.0, 1 + 3 * 2 * 3).reshape(3, 2, 3) if points is None else points
        file = ezc3d.c3d()
        file["parameters"]["POINT"]["RATE"]["value"] = [50.0]
        file["parameters"]["POINT"]["LABELS"]["value"] = list(labels)
        file["parameters"]["POINT"]["UNITS"]["value"] = [unit]
        file["data"]["points"] = np.concatenate([points, np.ones((1, *points.shape[1:]))])
        file.write(str(tmp_path / "a.c3d"))
        return tmp_path / "a.c3d"

    return write


def test_markers_in_metres_with_what_is_lost_unknown(written):
    points = np.arange(1.0, 19).reshape(3, 2, 3)
    lost = 1000 * points
    lost[:, 1, 1] = np.nan
    motion = c3d.read(written(points=lost))
    assert motion.skeleton.joints == ("LFHD", "C7")
    assert motion.skeleton.parents == (-1, -1)
    assert motion.rate == 50
    np.testing.assert_allclose(motion.positions[[0, 2]], points.transpose(2, 1, 0)[[0, 2]], rtol=1e-6)
    np.testing.assert_allclose(motion.positions[1, 0], points[:, 0, 1], rtol=1e-6)
    assert np.isnan(motion.positions[1, 1]).all()
    assert motion.rotations is None


def test_units_are_those_of_the_file_unless_told(written):
    assert c3d.read(written(unit="m")).positions[0, 0, 0] == pytest.approx(1000)
    assert c3d.read(written(unit="m"), unit=0.5, rate=10).positions[0, 0, 0] == pytest.approx(500)
    with pytest.raises(FormatError, match="a.c3d: unknown unit 'ell'.*--unit"):
        c3d.read(written(unit="ell"))


def test_no_markers_damage_and_no_file(written, tmp_path):
    with pytest.raises(FormatError, match="no markers in it"):
        c3d.read(written(labels=(), points=np.empty((3, 0, 3))))
    whole = written().read_bytes()
    (tmp_path / "b.c3d").write_bytes(b"no c3d at all")
    with pytest.raises(FormatError, match="b.c3d: not readable as C3D"):
        c3d.read(tmp_path / "b.c3d")
    for length in (0, 100, 512, 700):
        (tmp_path / "b.c3d").write_bytes(whole[:length])
        with pytest.raises(FormatError, match="b.c3d: (the file is cut off|not readable as C3D)"):
            c3d.read(tmp_path / "b.c3d")
    long = written(points=np.ones((3, 2, 400))).read_bytes()
    for length in (2000, len(long) // 2, len(long) - 2100):
        (tmp_path / "b.c3d").write_bytes(long[:length])
        with pytest.raises(FormatError, match="b.c3d: the file is cut off"):
            c3d.read(tmp_path / "b.c3d")
    with pytest.raises(FormatError, match="none.c3d: no such file"):
        c3d.read(tmp_path / "none.c3d")


def test_without_the_extra_it_is_named(written, monkeypatch):
    monkeypatch.setitem(sys.modules, "ezc3d", None)
    with pytest.raises(
        IpcliError, match=r"a.c3d: C3D files need the package ezc3d. Install it with pip install 'ipcli\[c3d\]'"
    ):
        c3d.read(written())


def test_markers_of_one_name_are_told_apart(written):
    motion = c3d.read(written(labels=("*1", "*1")))
    assert motion.skeleton.joints == ("*1", "*1_2")
    assert motion.notes == ("several joints are named *1: told apart by numbers",)


@pytest.mark.parametrize("group", ["ANGLES", "FORCES", "MOMENTS", "POWERS"])
def test_what_a_model_computed_is_no_marker(written, group):
    path = written(labels=("LFHD", "LKneeAngles"))
    file = ezc3d.c3d(str(path))
    file.add_parameter("POINT", group, ["LKneeAngles"])
    file.write(str(path))
    motion = c3d.read(path)
    assert motion.skeleton.joints == ("LFHD",)
    assert "1 outputs of a model" in motion.notes[0]
