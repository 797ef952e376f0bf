"""The experiments of chapter 4: the printed tables, the scale space, the generated recordings, and each target as
QUICK=1.
"""

import csv
import json

import numpy as np
import pytest

from experiments.fusion import page, recordings, scale_space
from experiments.kit.bars import read_bars
from ipcli.io.views import kitti, layouts
from ipcli.models.fusion.parameters import parse_variants
from ipcli.models.fusion.scenes import INITIAL
from tests.fixtures.makefile import make

LABELS = {*INITIAL, *(variant.label for variant in parse_variants("all"))}


def printed(name):
    (table,) = page.printed_tables(name)
    return table


@pytest.mark.parametrize("name", ["objects", "urban"])
def test_the_averages_that_the_thesis_prints_follow_from_its_columns(name):
    """A check of every figure as it was copied: Z-avg is the geometric mean of the three columns before it."""
    table = printed(name)
    for _, ours, *values in table.rows:
        *three, average = map(float, values[: table.columns.index("Z-avg") - 1])
        assert ours in LABELS
        assert np.exp(np.mean(np.log(three))) == pytest.approx(average, rel=1e-3)


def test_the_page_finds_every_table_and_bar():
    tables = page.printed_tables("kitti")
    assert [table.title[:9] for table in tables] == ["Table 4.4", "Table 4.4", "Table 4.5", "Table 4.5"]
    assert all(ours in LABELS for table in tables for _, ours, *_ in table.rows)
    measures = {*printed("objects").columns, "MAE", "out-3 % / median"}
    for name in page.EXPERIMENTS:
        bars = read_bars(page.HERE / "bars.csv", name)
        assert bars
        assert {bar.measure for bar in bars} <= {(measure,) for measure in measures}
        assert all(isinstance(bar.bar, float) for bar in bars)


def test_a_box_goes_when_the_even_confidence_falls_below_its_perimeter_over_its_area():
    """TV-L1 with c keeps a box of side a for c well above 4 / a and drops it for c well below (2 + sqrt(pi)) / a,
    whatever its height.
    """
    s = scale_space
    image = s.boxes()
    for c in (0.3, 1.5):
        x = s.regularised(image, np.full_like(image, c))
        for row, column, side, height in s.BOXES:
            middle = x[row + side // 2, column + side // 2]
            if c > 1.15 * 4 / side:
                assert middle == pytest.approx(height, abs=0.02)
            elif c < 0.9 * (2 + np.sqrt(np.pi)) / side:
                assert middle == pytest.approx(0, abs=0.02)


def test_the_generated_street_is_one_scene_in_both_cameras_and_the_room_one_in_all_views(tmp_path, monkeypatch):

    monkeypatch.setattr(recordings, "SCENES", ("000000",))
    recordings.make_street(tmp_path / "street")
    left, right = (image[..., 0].astype(float) for image in kitti.pair(tmp_path / "street", "000000", "10"))
    disparity = kitti.truth(tmp_path / "street", "000000")
    rows, columns = np.nonzero(np.isfinite(disparity))
    matched = right[rows, np.round(columns - disparity[rows, columns]).astype(int)]
    assert (
        np.median(np.abs(left[rows, columns] - matched))
        < 5
        < np.median(np.abs(left[rows, columns] - right[rows, columns]))
    )
    assert len(kitti.poses(tmp_path / "street" / "poses", "000000")) == 12
    recordings.make_room(tmp_path / "room")
    room = layouts.open_views(tmp_path / "room", intrinsics=tuple(recordings.ROOM_CAMERA[[0, 1, 0, 1], [0, 1, 2, 2]]))
    from ipcli.models.fusion.reprojection import reproject

    one, other = room.load("00010"), room.load("00011")
    seen, _ = reproject(other, one)
    both = np.isfinite(seen) & np.isfinite(one.depth)
    assert np.median(np.abs(seen - one.depth)[both]) < 0.01


@pytest.mark.slow
@pytest.mark.parametrize("name", ["objects", "urban", "kitti", "livingroom"])
def test_a_quick_look_ends_in_a_page_with_figures_and_a_table(name, tmp_path):
    """From nothing, in a folder of its own; with data that are not there."""
    make(tmp_path, "QUICK=1", f"experiments/fusion-{name}")
    folder = tmp_path / "build" / "experiments" / f"fusion-{name}-quick"
    html, table = (folder / "index.html").read_text(), json.loads((folder / "index.json").read_text())
    assert "quick look" in html
    assert all(row["method"].split(",")[0] in html for row in table["rows"])
    with (folder / "index.csv").open() as stream:
        rows = {row["method"]: float(row["RMSE"]) for row in csv.DictReader(stream)}
    assert rows["tgv-l1"] < rows["median"] < rows["reference"]
    assert {path.suffix for path in (folder / "figures").iterdir()} == {".pdf", ".png"}
