"""Gaze exports: axes, clocks and units of each device on small files written here."""

import gzip
import json

import numpy as np
import pytest

from ipcli.errors import FormatError
from ipcli.io.gaze import gaze_files


def write(path, text):
    path.write_text(text)
    return path


def test_pupil_cloud_has_nanoseconds_and_pixels_and_marks_blinks(tmp_path):
    header = "section id,recording id,timestamp [ns],gaze x [px],gaze y [px],worn,fixation id,blink id\n"
    rows = "a,b,1685088813175076015,629.1,647.9,1.0,1,\na,b,1685088813183430015,1,2,1.0,,3\n"
    rows += "a,b,1685088813191430015,1,2,0.0,,\n"
    gaze = gaze_files.read_gaze(write(tmp_path / "gaze.csv", header + rows))
    assert gaze.source == "Pupil Cloud"
    assert gaze.times[0] == pytest.approx(1685088813.175076, abs=1e-5)
    assert gaze.pixels[0].tolist() == [629.1, 647.9]
    assert gaze.valid.tolist() == [True, False, False]


def test_pupil_core_counts_from_the_bottom_left(tmp_path):
    text = "gaze_timestamp,world_index,confidence,norm_pos_x,norm_pos_y\n1.5,0,0.9,0.25,0.75\n1.6,0,0.1,0.5,0.5\n"
    gaze = gaze_files.read_gaze(write(tmp_path / "gaze_positions.csv", text), (400, 200))
    assert np.allclose(gaze.pixels[0], [99.5, 49.5])
    assert gaze.valid.tolist() == [True, False]
    with pytest.raises(FormatError, match="--gaze-size"):
        gaze_files.read_gaze(tmp_path / "gaze_positions.csv")


def test_arias_angles_are_left_and_up(tmp_path):
    text = "tracking_timestamp_us,yaw_rads_cpf,pitch_rads_cpf,depth_m\n2000000,0.1,0.2,\n"
    gaze = gaze_files.read_gaze(write(tmp_path / "eyegaze.csv", text))
    x, y, z = gaze.directions[0]
    assert gaze.times[0] == 2.0
    assert x / z == pytest.approx(-np.tan(0.1))
    assert y / z == pytest.approx(-np.tan(0.2))


def test_tobii_two_and_three_are_shares_from_the_top_left(tmp_path):
    two = [
        {"ts": 84415010, "s": 0, "gidx": 1, "gp": [0.25, 0.5]},
        {"ts": 84415020, "s": 1, "gp": [0, 0]},
        {"ts": 1, "ac": [0]},
    ]
    three = [
        {"type": "gaze", "timestamp": 0.5, "data": {"gaze2d": [0.5, 0.25]}},
        {"type": "gaze", "timestamp": 0.6, "data": {}},
    ]
    for name, lines, expected in (("livedata.json.gz", two, [99.5, 99.5]), ("gazedata.gz", three, [199.5, 49.5])):
        with gzip.open(tmp_path / name, "wt") as stream:
            stream.write("\n".join(map(json.dumps, lines)) + "\n")
        gaze = gaze_files.read_gaze(tmp_path / name, (400, 200))
        assert len(gaze.times) == 1
        assert np.allclose(gaze.pixels[0], expected)


def test_a_plain_table_with_rays_and_labels(tmp_path):
    text = "time [s],dx,dy,dz,label\n0.1,0,0,2,cup\n0.3,0,1,1,\n0.2,,,,cup\n"
    gaze = gaze_files.read_gaze(write(tmp_path / "any.csv", text))
    assert gaze.times.tolist() == [0.1, 0.2, 0.3]
    assert gaze.directions[0].tolist() == [0, 0, 1]
    assert gaze.valid.tolist() == [True, False, True]
    assert gaze.labels[0] == "cup"


def test_a_last_line_without_an_end_is_not_trusted(tmp_path):
    gaze = gaze_files.read_gaze(write(tmp_path / "a.csv", "time [s],x [px],y [px]\n0,1,2\n1,3,45"))
    assert len(gaze.times) == 1


def test_times_that_repeat_are_left_out_and_told(tmp_path):
    gaze = gaze_files.read_gaze(write(tmp_path / "a.csv", "time [s],x [px],y [px]\n0,1,2\n0,3,4\n,5,6\n"))
    assert len(gaze.times) == 1
    assert gaze.dropped == ("2 gaze samples have no time of their own",)


@pytest.mark.parametrize(
    ("text", "what"),
    [
        ("", "no gaze samples"),
        ("a,b\n1,2\n", "unknown gaze table"),
        ("time [s],x [px],y [px]\n1,2\n", "line 2 is cut"),
        ("timestamp [ns],gaze x [px],gaze y [px]\n\u00b2,1,2\n", "no time"),
    ],
)
def test_what_is_no_gaze_is_refused(tmp_path, text, what):
    with pytest.raises(FormatError, match=what):
        gaze_files.read_gaze(write(tmp_path / "a.csv", text))


def test_clocks_that_do_not_overlap_are_refused_with_the_cure(tmp_path):
    gaze = gaze_files.read_gaze(write(tmp_path / "a.csv", "time [s],x [px],y [px]\n100,1,2\n101,3,4\n"))
    with pytest.raises(FormatError, match="--gaze-shift: -95.000"):
        gaze_files.on_clock(gaze, np.array([5.0, 9.0]), 0.0, tmp_path)
    assert gaze_files.on_clock(gaze, np.array([5.0, 9.0]), -95.0, tmp_path).times.tolist() == [5, 6]
