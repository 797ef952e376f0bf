"""The page of clips, whatever they lack."""

from __future__ import annotations

import numpy as np
import pytest

from ipcli import schema
from ipcli.io.motion.kinect import KINECT
from ipcli.report.mocap import clips
from tests.fixtures.pages import ESCAPED, HOSTILE, Balance
from tests.fixtures.report_artefacts import texts


def artefact(joints=KINECT.joints, parents=KINECT.parents):
    rng = np.random.default_rng(1)
    return {
        "clips": texts("a", HOSTILE, "c"),
        "labels": texts("kick", HOSTILE, ""),
        "actors": texts("ann", "ann", HOSTILE),
        "frames": np.array([4, 1, 2]),
        "rates": np.array([30.0, 30.0, 15.0]),
        "joints": np.array(joints),
        "parents": np.array(parents),
        "positions": rng.normal(size=(7, len(joints), 3)).astype(np.float32),
        "split_names": texts("01"),
        "splits": np.array([[1, 2, 2]], np.int8),
    }


@pytest.mark.parametrize("case", ["whole", "own skeleton", "gaps", "nothing seen at first", "no splits"])
def test_every_clip_counts_and_nothing_escapes(case):
    arrays = artefact() if case != "own skeleton" else artefact(("a", "b"), (-1, 0))
    if case == "gaps":
        arrays["positions"][1:3, 4:9] = np.nan
    if case == "nothing seen at first":
        arrays["positions"][0] = np.nan
    if case == "no splits":
        del arrays["splits"], arrays["split_names"]
    schema.validate(schema.kind("clips"), arrays)
    html = clips.page(arrays, {})
    page = Balance(html)
    assert "3 clips of 3 actions by 2 actors: 7 frames" in html
    assert ESCAPED in html
    assert "<script>" not in html
    assert html.count("<svg") == 4 + 1 + 2
    assert ("Published splits" in html) == (case != "no splits")
    assert page.links == []
    assert html == clips.page(arrays, {})


def test_the_table_counts_clips_of_each_action_and_actor():
    html = clips.page(artefact(), {})
    assert ">kick<" in html
    assert "unlabelled" in html
    assert "1 (ann)" in html


def test_no_clips():
    arrays = {name: array[..., :0] if name == "splits" else array[:0] for name, array in artefact().items()}
    arrays |= {"joints": texts("a"), "parents": np.array([-1]), "positions": np.empty((0, 1, 3), np.float32)}
    assert "holds no clip" in clips.page(arrays, {})
