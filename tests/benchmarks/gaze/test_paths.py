"""Both methods find the same path on the same frames, in the frame of the truth's scale."""

import json

import pytest

from benchmarks.gaze import paths


@pytest.mark.slow  # pycolmap takes half a minute
def test_both_pose_every_frame_to_millimetres(tmp_path):
    pytest.importorskip("pycolmap")
    paths.main(["--quick", "--threads", "1", "--output", str(tmp_path)])
    tables = json.loads((tmp_path / "gaze_paths.json").read_text())["tables"]
    rows = tables["The same frames"]
    assert [row["method"] for row in rows] == ["gaze-sfm", "pycolmap, rig fixed"]
    for row in rows:
        assert row["posed"] == row["frames"] == 16
        assert row["error [m]"] < 0.005
        assert row["scale"] == pytest.approx(1, abs=0.01)  # a metric rig, not a free one


def test_a_recording_or_quick_must_be_given(capsys):
    with pytest.raises(SystemExit):
        paths.main([])
    assert "--recording" in capsys.readouterr().err
