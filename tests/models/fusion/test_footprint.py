"""What a fusion takes is told before it starts: near the peak of a real one, and never less."""

import os
import re
import subprocess
import sys
from dataclasses import replace

import pytest

from ipcli.models.fusion import footprint as footprint_module
from ipcli.models.fusion.footprint import SIDE, SIDES, FusionSize, MergeSize, footprint, side_by_size, side_within
from ipcli.models.fusion.parameters import Fusion

LARGE = FusionSize((3650, 5480), 8, 3, at_once=2)
CHILD = """
import re, sys
from pathlib import Path
from ipcli.inverse.regularize.parameters import Solver
from ipcli.measurements.views import View
from ipcli.models.fusion.fuse import fuse
from ipcli.models.fusion.tiles import fuse_in_tiles
from ipcli.models.fusion.parameters import Fusion
from tests.fixtures.fusion_scenes import scene
side, quick = int(sys.argv[1]), Fusion(rounds=1, solver=Solver(iterations=2))
views = scene({views}, {shape})
if side:
    fuse_in_tiles(views, views[1], quick, side, inverse=False)
else:
    fuse(views, views[1], quick, inverse=False)
print(re.search(r"VmHWM:\\s+(\\d+)", Path("/proc/self/status").read_text())[1])
"""

MERGE = """
import re, sys
from pathlib import Path
import numpy as np
from ipcli.geometry.surface import normals
from ipcli.models.fusion.merge import FusedMap, merge
from ipcli.models.fusion.parameters import Merge
from tests.fixtures.fusion_scenes import camera, cast, pose_at
shape, held = {shape}, {{}}
def one(k):
    intrinsics, pose = camera(shape), pose_at((0.04 * (k - 2), 0.01 * (k % 2), 0.0), 0.02 * (k - 2))
    depth = cast(shape, intrinsics, pose).astype(np.float32)
    facing, noise = normals(depth, intrinsics).astype(np.float32), np.full(shape, 0.01, np.float32)
    seen, color = np.full(shape, 5, np.uint16), np.zeros((*shape, 3), np.uint8)
    return FusedMap(depth, np.ones(shape, np.float32), seen, facing, noise, intrinsics, pose, color)
cloud = merge([one(k) for k in range({maps})], Merge())
print(len(cloud.points.views), re.search(r"VmHWM:\\s+(\\d+)", Path("/proc/self/status").read_text())[1])
"""


@pytest.mark.slow
@pytest.mark.skipif(not os.path.exists("/proc/self/status"), reason="the peak is read from /proc")
def test_the_estimate_holds_the_peak_of_a_real_merge_and_is_near_it():
    shape, maps = (800, 1000), 5
    code = MERGE.format(shape=shape, maps=maps)
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True)
    points, peak = (int(number) for number in done.stdout.split())
    size = MergeSize(shape[0] * shape[1], maps * shape[0] * shape[1], 2, maps, 2)
    assert points < size.cells()
    assert 1024 * peak < 1.05 * size.footprint(points)
    assert size.footprint(points) < 1.6 * 1024 * peak


def test_a_merge_holds_fewer_maps_and_a_smaller_cloud_where_memory_is_short():
    size = MergeSize(5_000_000, 100_000_000, 2, 20, 2)
    assert size.within(10**12) == size
    tight = size.within(size.footprint(size.cells()) - 1)
    assert 4 <= tight.held < size.held
    assert tight.footprint(size.cells()) < size.footprint(size.cells())
    assert size.within(10**8).held == 4
    limit = size.footprint(10**6)
    assert size.most_cells(limit) >= 10**6
    assert size.footprint(size.most_cells(limit)) <= limit < size.footprint(size.most_cells(limit) + 1)
    assert size.most_cells(0) == 0
    assert replace(size, agree=5).cells() < size.cells()


@pytest.mark.slow
@pytest.mark.skipif(not os.path.exists("/proc/self/status"), reason="the peak is read from /proc")
@pytest.mark.parametrize("side", [0, 256])
def test_the_estimate_holds_the_peak_of_a_real_fusion_and_is_near_it(side, monkeypatch):
    monkeypatch.setattr(footprint_module, "PUBLISHING", footprint_module.PROCESS)  # neither mesh nor page is made here
    monkeypatch.setattr(footprint_module, "PICTURED", 0)
    shape, views = (1000, 1600), 4
    code = CHILD.format(views=views, shape=shape)
    done = subprocess.run([sys.executable, "-c", code, str(side)], capture_output=True, text=True, check=True)
    peak = 1024 * int(re.search(r"\d+", done.stdout)[0])
    told = footprint(
        FusionSize(shape, 8 * views, views, at_once=2), Fusion(), side
    )  # the test holds all views, with truth
    assert peak < 1.05 * told
    assert told < 1.6 * peak


def test_twenty_megapixels_of_three_views_fit_two_gigabytes_in_tiles_alone():
    assert footprint(LARGE, Fusion(), 0) > 5e9
    assert side_within(LARGE, Fusion(), 2 * 10**9) == SIDE
    assert side_within(LARGE, Fusion(), 8 * 10**9) == SIDE  # whatever the limit, the map is the same where it can be
    side = side_within(LARGE, Fusion(), 1_700_000_000)
    assert side in SIDES
    assert footprint(LARGE, Fusion(), side) <= 1_700_000_000 < footprint(LARGE, Fusion(), SIDE)
    assert side_within(LARGE, Fusion(), 10**9) is None


def test_tiles_that_were_asked_for_are_taken_or_nothing():
    assert side_within(LARGE, Fusion(tile=100), 2 * 10**9) == 100
    assert side_within(LARGE, Fusion(tile=0), 2 * 10**9) is None
    assert side_within(replace(LARGE, views=41), Fusion(), 40 * 10**9) == SIDE  # as many observations are tiled anyhow


def test_more_views_weights_and_confidences_take_more():
    few = footprint(LARGE, Fusion(), 0)
    assert footprint(replace(LARGE, views=4), Fusion(), 0) > few
    assert footprint(replace(LARGE, given_confidence=True), Fusion(), 0) > few
    assert footprint(LARGE, Fusion(method="l1-adapt-views"), 0) > few
    sides = [footprint(LARGE, Fusion(), side) for side in (256, 512, 1024, 2048)]
    assert sides == sorted(sides)


def test_large_fusions_are_tiled_by_themselves_and_others_when_told():
    assert side_by_size(FusionSize((480, 640), 8, 11), Fusion()) == 0
    assert side_by_size(FusionSize((3000, 4000), 8, 41), Fusion()) == SIDE
    assert side_by_size(FusionSize((3000, 4000), 8, 41), Fusion(tile=0)) == 0
    assert side_by_size(FusionSize((480, 640), 8, 11), Fusion(tile=101)) == 104
