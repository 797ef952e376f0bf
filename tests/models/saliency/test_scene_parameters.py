"""Parameters of scenes are declared with defaults that their own rules accept."""

from ipcli.models.saliency import features
from ipcli.models.saliency.scene_parameters import SceneSaliency
from ipcli.params import leaves, resolve


def test_defaults_are_accepted_and_groups_left_out_exist():
    given = [f"{leaf.key}={leaf.default}" for leaf in leaves(SceneSaliency)]
    assert resolve(SceneSaliency, sets=given) == SceneSaliency()
    assert set(SceneSaliency().classifying.leave_out.split(",")) <= set(features.GROUPS)
