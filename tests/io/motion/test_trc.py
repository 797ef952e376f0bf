"""TRC: markers in the unit of the file, empty cells NaN, and a head that has to fit its table."""

import numpy as np
import pytest

from ipcli.errors import FormatError
from ipcli.io.motion import trc
from tests.fixtures.errors import check_message


def text(names=("C7", "LASI"), frames=3, unit="mm", rate=100, stated=None, values=None):
    values = np.arange(frames * len(names) * 3, dtype=float) + 1 if values is None else values
    table = np.asarray(values).reshape(frames, -1)
    rows = [
        "\t".join([str(n + 1), f"{n / rate:.3f}", *("" if np.isnan(x) else f"{x:g}" for x in row)])
        for n, row in enumerate(table)
    ]
    axes = "\t".join(f"{axis}{n + 1}" for n in range(len(names)) for axis in "XYZ")
    return "\n".join(
        [
            "PathFileType\t4\t(X/Y/Z)\ta.trc",
            "DataRate\tCameraRate\tNumFrames\tNumMarkers\tUnits\tOrigDataRate\tOrigDataStartFrame\tOrigNumFrames",
            f"{rate}\t{rate}\t{stated or frames}\t{len(names)}\t{unit}\t{rate}\t1\t{frames}",
            "Frame#\tTime\t" + "\t\t\t".join(names) + "\t\t",
            "\t\t" + axes,
            "",
            *rows,
            "",
        ]
    )


def save(tmp_path, content):
    (tmp_path / "a.trc").write_text(content, encoding="utf-8")
    return tmp_path / "a.trc"


@pytest.mark.parametrize(("unit", "metres"), [("mm", 1e-3), ("m", 1.0)])
def test_markers_come_in_metres_at_the_rate_of_the_file(tmp_path, unit, metres):
    motion = trc.read(save(tmp_path, text(unit=unit)))
    assert motion.skeleton.joints == ("C7", "LASI")
    assert motion.rate == 100
    np.testing.assert_allclose(motion.positions.ravel(), metres * (np.arange(18) + 1))
    assert not motion.notes


def test_hints_replace_what_the_file_says(tmp_path):
    motion = trc.read(save(tmp_path, text()), rate=50.0, unit=0.01)
    assert motion.rate == 50
    assert motion.positions[0, 0, 0] == pytest.approx(0.01)


def test_empty_cells_and_zeros_were_not_seen(tmp_path):
    values = np.arange(18.0) + 1
    values[3:6], values[9:12] = np.nan, 0
    motion = trc.read(save(tmp_path, text(values=values)))
    np.testing.assert_array_equal(
        np.isnan(motion.positions).all(axis=-1), [[False, True], [False, True], [False, False]]
    )


def test_markers_of_one_name_are_told_apart(tmp_path):
    motion = trc.read(save(tmp_path, text(names=("A", "A"))))
    assert motion.skeleton.joints == ("A", "A_2")
    assert "told apart" in motion.notes[0]


@pytest.mark.parametrize(
    ("content", "mentioned"),
    [
        ("PathFileType\t4\t(X/Y/Z)\ta.trc\n", "not a whole TRC file"),
        ("hello\n", "not a TRC file"),
        (text(stated=9), "expected 9, got 3"),
        (text().replace("\t2\tmm", "\t5\tmm"), "names of markers"),
        (text(unit="ell"), "unknown unit 'ell'"),
        (text().replace("\n3\t", "\n2\t"), "line 9: frame numbers do not grow"),
        (text().replace("\t18\n", "\tx\n"), "line 9: could not convert"),
        (text().replace("\t18\n", "\n"), "line 9: cells"),
    ],
)
def test_what_contradicts_itself_is_refused(tmp_path, content, mentioned):
    with pytest.raises(FormatError) as raised:
        trc.read(save(tmp_path, content))
    check_message(raised.value, "a.trc", mentioned)
