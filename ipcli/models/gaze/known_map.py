"""A map to localise in, of an earlier run or of somebody's structure from motion: points with their descriptors, and
which frames or pictures saw which.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, replace

import numpy as np

from ipcli.errors import NoSolution
from ipcli.geometry import lie
from ipcli.measurements.recording import PictureModel
from ipcli.models.gaze.features import StereoFeatures, detect
from ipcli.models.gaze.parameters import Detection
from ipcli.models.gaze.retrieval import Album, learn_words
from ipcli.models.gaze.scene_map import NONE, MapFrame, SceneMap

WANTED = ("map/points", "map/descriptors", "map/sightings", "map/grey", "world_from_rig")
SAMPLED = 8  # frames whose descriptors the words of the album are learnt from


NEAR = 2.0  # pixels between a point of a model and a feature that is taken for it
MORE = 4  # features looked for, in multiples of the points that a picture shows


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
        _add_seen(scene, int(number), lie.se3_inverse(a["world_from_rig"][number]), np.unique(mine[:, 2]))
    if not scene.frames:
        raise NoSolution("the run of --map has no map: give one that localised its wearer in more than one camera")
    return KnownMap(scene, a["map/grey"])


def map_of_model(model: PictureModel, p: Detection) -> KnownMap:
    """The map of a structure-from-motion model, whose unit is taken for the metre.

    Models keep no descriptors. Features are found on its pictures, and the one nearest to where a picture shows a point
    (within `NEAR` pixels) describes it; the nearest of all pictures counts. NoSolution when no point gets one.
    """
    from scipy.spatial import cKDTree

    descriptors = np.zeros((len(model.points), 128), np.uint8)
    nearest = np.full(len(model.points), np.inf)
    for k, (shown, pixels) in enumerate(zip(model.shown, model.pixels, strict=True)):
        found, _, described = detect(model.load(k), replace(p, count=max(p.count, MORE * len(shown))))
        if not len(found):
            continue
        distance, feature = cKDTree(found).query(pixels, distance_upper_bound=NEAR)
        closer = np.flatnonzero(distance < nearest[shown])
        nearest[shown[closer]], descriptors[shown[closer]] = distance[closer], described[feature[closer]]
    known = np.isfinite(nearest)
    if not known.any():
        raise NoSolution("no point of the model is at a feature of its pictures: are they those it was made of?")
    number = np.where(known, np.cumsum(known) - 1, NONE)
    scene = SceneMap(model.points[known], descriptors[known], [[] for _ in range(known.sum())], [])
    scene.count = len(scene.points)
    for k, shown in enumerate(model.shown):
        ids = np.unique(number[shown])
        _add_seen(scene, k, model.poses[k], ids[ids != NONE])
    return KnownMap(scene, model.grey[known])


def _add_seen(scene: SceneMap, number: int, pose: np.ndarray, ids: np.ndarray) -> None:
    """A frame that saw these points; none where it has no pose or saw nothing."""
    if not len(ids) or not np.isfinite(pose).all():
        return
    for point in ids:
        scene.observers[point].append(len(scene.frames))
    scene.frames.append(MapFrame(number, _nothing(), pose, ids))


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
