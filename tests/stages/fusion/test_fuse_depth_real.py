"""fuse-depth on real recordings: what it must gain on the input."""

import numpy as np
import pytest

from ipcli.io.files import h5
from ipcli.models.fusion.parameters import Fusion
from ipcli.params import Run
from ipcli.stages.fusion import fuse_depth, import_views, kitti_views
from ipcli.stages.fusion.parameters import FuseDepth, ImportViews, KittiViews

pytestmark = pytest.mark.real
QUICK = Fusion(method="tgv-l1")


def measures(path):
    arrays = h5.read(path, "fused-depth").arrays
    columns = [str(name) for name in arrays["metric_columns"]]
    return {
        str(row): dict(zip(columns, values, strict=True))
        for row, values in zip(arrays["metric_rows"], arrays["metrics"], strict=True)
    }


def test_kitti_fused_disparities_beat_the_median_and_the_reference(real_data, tmp_path):
    folder, poses = (
        real_data("fusion/kitti2012_pairs"),
        real_data("fusion/kitti2012_poses") / "poses_training_cam2world.npz",
    )
    kitti_views.run(folder, poses, tmp_path, KittiViews(scenes="40"), Run())
    params = FuseDepth(reference="10_left", fusion=QUICK)
    fuse_depth.run(tmp_path / "000040.views.h5", tmp_path / "fused.h5", params, Run())
    found = measures(tmp_path / "fused.h5")
    assert found["fused"]["out-3 %"] < found["median"]["out-3 %"] < found["reference"]["out-3 %"]
    assert found["fused"]["D-avg px"] < found["median"]["D-avg px"]


def test_living_room_error_is_at_most_60_per_cent_of_the_median_s(real_data, tmp_path):
    source = real_data("fusion/livingroom1_clean_micro")
    views = ImportViews(reference="00100", window=11, noise="laplace:0.03")
    import_views.run(source, tmp_path / "room.views.h5", views, Run())
    fuse_depth.run(tmp_path / "room.views.h5", tmp_path / "fused.h5", FuseDepth(reference="00100", fusion=QUICK), Run())
    found = measures(tmp_path / "fused.h5")
    assert found["fused"]["MAE"] < 0.6 * found["median"]["MAE"] < 0.6 * found["mean"]["MAE"]
    assert found["fused"]["N-MAE rad"] < 0.25 < 1 < found["median"]["N-MAE rad"]


def test_kinect_frames_agree_with_a_held_out_frame_better_than_one_frame_does(real_data, tmp_path):
    """Fused without the frame before the reference, the map must predict that frame better than the reference frame
    does.
    """
    from ipcli.io.views import layouts
    from ipcli.models.fusion.fuse import fuse
    from ipcli.models.fusion.reprojection import reproject

    sequence = layouts.open_views(real_data("fusion/sevenscenes_kitchen"))
    views = {name: sequence.load(name) for name in sequence.names[25:36]}
    reference, held_out = views["frame-000180"], views.pop("frame-000179")
    fused = fuse(list(views.values()), reference, QUICK, inverse=False)
    seen, _ = reproject(held_out, reference)
    both = np.isfinite(seen) & np.isfinite(reference.depth) & (fused.observations > 0)
    assert np.median(np.abs(fused.depth - seen)[both]) < 0.9 * np.median(np.abs(reference.depth - seen)[both])
