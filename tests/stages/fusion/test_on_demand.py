"""A view by rectangles is the view."""

import numpy as np
import pytest

from ipcli.io.files.scratch import ScratchFiles
from ipcli.models.fusion.windows import Window
from ipcli.stages.fusion.on_demand import ViewsOnDemand
from ipcli.stages.fusion.parameters import FuseDepth
from ipcli.stages.fusion.sources import open_source
from tests.fixtures.fusion_scenes import scene, write


@pytest.mark.parametrize("kept", [False, True], ids=["source", "scratch"])
def test_a_rectangle_is_cut_from_the_view(tmp_path, kept):
    source = open_source(write(tmp_path / "a.views.h5", scene(3, (30, 40))), FuseDepth().source)
    reference, window = source.load(source.names[1]), Window(slice(4, 19), slice(7, 90))
    with ScratchFiles(tmp_path) as scratch:
        views = ViewsOnDemand(source, source.names, reference, scratch if kept else None)
        for _ in range(2):
            for k, name in enumerate(source.names):
                whole, part = source.load(name), views.part(k, window)
                np.testing.assert_array_equal(part.depth, whole.depth[4:19, 7:])
                np.testing.assert_array_equal(part.intrinsics[:2, 2], whole.intrinsics[:2, 2] - (7, 4))
                np.testing.assert_array_equal(part.cam_from_world, whole.cam_from_world)
                np.testing.assert_array_equal(views[k].depth, whole.depth)
        assert views[1] is not reference
        with pytest.raises(IndexError):
            views[3]
