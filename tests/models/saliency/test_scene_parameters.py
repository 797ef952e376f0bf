"""Parameters of scenes are declared with defaults that their own rules accept."""

from ipcli.models.saliency import features
from ipcli.models.saliency.scene_parameters import Scene
from ipcli.params import leaves, resolve


def test_defaults_are_accepted_and_groups_left_out_exist():
    given = [f"{leaf.key}={leaf.default}" for leaf in leaves(Scene)]
    assert resolve(Scene, sets=given) == Scene()
    assert set(Scene().classifying.leave_out.split(",")) <= set(features.GROUPS)
