"""Views that went into an artefact come back from it, view by view, and only what is asked for is read."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from ipcli import schema
from ipcli.errors import FormatError
from ipcli.io.files import h5
from ipcli.io.views import artefact
from tests.fixtures.fusion_scenes import damage, write


@pytest.fixture
def stored(tmp_path, views):
    """Three views of two sizes; the first with confidence and truth, the last without image."""
    small = replace(views[2], depth=views[2].depth[:7, :9], image=None)
    full = replace(views[0], confidence=np.ones_like(views[0].depth), truth=views[0].depth)
    path = tmp_path / "x.views.h5"
    arrays = artefact.views_arrays([small, full, views[1]], unit="m", measured="disparity", baseline_focal=40.0)
    h5.write(path, "views", arrays, {})
    return path, (full, views[1], small)


def test_an_artefact_gives_back_the_views_that_went_into_it(stored):
    path, written = stored
    sequence = artefact.read_views(path)
    assert (sequence.names, sequence.unit, sequence.measured, sequence.baseline_focal) == (
        ("0", "1", "2"),
        "m",
        "disparity",
        40.0,
    )
    assert sequence.files("1") == (path,)
    for name, view in zip(sequence.names, written, strict=True):
        found = sequence.load(name)
        for field in artefact.PER_VIEW:
            np.testing.assert_equal(getattr(found, field), getattr(view, field))


def test_an_artefact_with_a_pose_that_is_not_rigid_is_refused(tmp_path, views):
    path = write(tmp_path / "x.h5", views[1:2])
    assert artefact.read_views(path).baseline_focal is None
    damage(path, "views/1/cam_from_world", np.diag([2.0, 1.0, 1.0, 1.0]))
    with pytest.raises(FormatError, match="x.h5.*views/1/cam_from_world.*a rigid pose"):
        artefact.read_views(path).load("1")


def test_fields_are_those_of_the_schema(stored, views):
    path, _ = stored
    kind, arrays = schema.kind("views"), artefact.views_arrays(views, unit="m", measured="depth")
    schema.validate(kind, arrays)
    assert {field.name for field in kind.fields} == {
        *("unit", "measured", "baseline_focal"),
        *(f"views/*/{field}" for field in artefact.PER_VIEW),
    }
    assert set(h5.names(path)) >= {"views/0/confidence", "views/0/truth", "baseline_focal"}


def test_without_pictures_image_and_truth_are_left_unread(stored, monkeypatch):
    path, (full, *_) = stored
    sequence, asked, read = artefact.read_views(path), [], h5.read

    def spy(path, kind, only):
        asked.extend(name for name in h5.names(path) if only(name))
        return read(path, kind, only=only)

    monkeypatch.setattr(h5, "read", spy)
    found = sequence.load("0", pictures=False)
    assert (found.image, found.truth) == (None, None)
    np.testing.assert_array_equal(found.depth, full.depth)
    np.testing.assert_array_equal(found.confidence, full.confidence)
    assert set(asked) == {f"views/0/{field}" for field in ("depth", "intrinsics", "cam_from_world", "confidence")}


def test_views_come_in_the_order_of_their_names_whatever_they_hold(tmp_path, views):
    """A name may be the start of another, or look like a field."""
    names = ("depth", "1", "10", "1 b", "é")
    arrays = artefact.views_arrays(
        [replace(views[index % 3], name=name) for index, name in enumerate(names)], unit="m", measured="depth"
    )
    h5.write(tmp_path / "x.h5", "views", arrays, {})
    sequence = artefact.read_views(tmp_path / "x.h5")
    assert sequence.names == tuple(sorted(names))
    for index, name in enumerate(names):
        found = sequence.load(name)
        assert found.name == name
        np.testing.assert_array_equal(found.cam_from_world, views[index % 3].cam_from_world)


def test_an_artefact_of_another_kind_is_refused(tmp_path):
    with pytest.raises(FormatError, match=r"x\.h5: no such file"):
        artefact.read_views(tmp_path / "x.h5")
