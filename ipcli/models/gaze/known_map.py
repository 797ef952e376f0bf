"""An earlier run's map to localise in: its points with their descriptors, and which of its frames saw which."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np

from ipcli.errors import NoSolution
from ipcli.geometry import lie
from ipcli.models.gaze.features import StereoFeatures
from ipcli.models.gaze.retrieval import Album, learn_words
from ipcli.models.gaze.scene_map import NONE, MapFrame, SceneMap

WANTED = ("map/points", "map/descriptors", "map/sightings", "map/grey", "world_from_rig")
SAMPLED = 8  # frames whose descriptors the words of the album are learnt from


@dataclass(frozen=True, eq=False)
class KnownMap:
    """The map, and the grey level of each of its points."""

    scene: SceneMap
    grey: np.ndarray  # (p,) uint8


def known_map(a: Mapping[str, np.ndarray]) -> KnownMap:
    """The map of a `gaze-experiment`. Its frames keep no features: nothing is added to it nor adjusted."""
    if "map/descriptors" not in a:
        raise NoSolution("the run of --map keeps no descriptors of its map: make it anew with this version")
    sightings = a["map/sightings"]
    scene = SceneMap(a["map/points"].copy(), a["map/descriptors"].copy(), [[] for _ in a["map/points"]], [])
    scene.count = len(scene.points)
    for number in np.unique(sightings[:, 0]):
        mine = sightings[(sightings[:, 0] == number) & (sightings[:, 1] == 0)]
        ids = np.unique(mine[:, 2])
        pose = lie.se3_inverse(a["world_from_rig"][number])
        if not len(ids) or not np.isfinite(pose).all():
            continue
        for point in ids:
            scene.observers[point].append(len(scene.frames))
        scene.frames.append(MapFrame(int(number), _nothing(), pose, ids))
    if not scene.frames:
        raise NoSolution("the run of --map has no map: give one that localised its wearer in more than one camera")
    return KnownMap(scene, a["map/grey"])


def album_of(scene: SceneMap, rng: np.random.Generator) -> Album:
    """The frames of the map, for recognising where a picture was taken."""
    described = [scene.descriptors[frame.ids[frame.ids != NONE]] for frame in scene.frames]
    sample = np.unique(np.linspace(0, len(described) - 1, SAMPLED).astype(int))
    album = Album(learn_words([described[k] for k in sample], rng))
    for position, descriptors in enumerate(described):
        album.add(position, album.vector(descriptors))
    return album


def _nothing() -> StereoFeatures:
    none = np.empty((0, 2))
    return StereoFeatures(
        none, none, np.empty((0, 3)), np.empty(0), np.empty((0, 128), np.uint8), np.empty(0, int), usable=False
    )  # fmt: skip
