"""Saliency of a recording: surfaces, features, the learnt function, membranes and proto-objects (algorithm of 3.4).

Twice through the subsequences: once to sample points that are learnt from, once to predict. Between them only samples
are kept, and of what is predicted a cloud whose size depends on the scene, so that memory does not grow with time.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from typing import Any

import numpy as np

from ipcli import rng
from ipcli.errors import NoSolution, ParameterError
from ipcli.measurements.subsequences import PosedSequence, Subsequence, seen_at
from ipcli.models.saliency import classifier, features, membranes, proto_objects, regions, surface, worth
from ipcli.models.saliency.classifier import Learnt
from ipcli.models.saliency.gathered import GatheredCloud
from ipcli.models.saliency.scene_parameters import SceneSaliency
from ipcli.progress import Progress, silent

KEPT = 24  # prepared subsequences that are kept from the first pass for the second
SHOWN = 48  # pictures that the artefact keeps, with their maps
HITS = {1: 2, 0: 1, -1: 0}  # looked at in this subsequence, at some other time, never
STRONGEST = 3  # membranes that the artefact keeps
NEAR = 2  # frames: points of regard drawn in a picture
Arrays = dict[str, np.ndarray]


@dataclass(frozen=True, eq=False)
class Prepared:
    """A subsequence with its surface, the features of its nodes and what was looked at."""

    sub: Subsequence
    nodes: features.NodeFeatures
    labels: np.ndarray  # (n,) 1 attended, -1 never, 0 at some other time
    error: float  # metres


@dataclass(frozen=True, eq=False)
class CrossPredictor:
    """What predicts each subsequence."""

    functions: dict[int, tuple[Learnt, ...]]  # by subsequence
    rest: tuple[Learnt, ...]  # for those that nothing was learnt from; empty: nothing is learnt at all

    def saliency(self, number: int, table: np.ndarray) -> np.ndarray:
        """In [0, 1] for rows of a table; NaN where nothing is learnt."""
        functions = self.functions.get(number, self.rest)
        if not functions:
            return np.full(len(table), np.nan)
        return classifier.combined(functions, [1.0] * len(functions), table)

    def domain(self) -> np.ndarray | None:
        """Union of the task domains: D of the algorithm."""
        if not self.rest:
            return None
        both = np.stack([function.domain for function in self.rest])
        return np.stack([both[:, 0].min(axis=0), both[:, 1].max(axis=0)])

    def elicited(self, number: int, table: np.ndarray) -> np.ndarray:
        """Rows that any of the functions puts above its threshold; all where nothing is learnt."""
        functions = self.functions.get(number, self.rest)
        above = [function.margin(table) >= function.threshold for function in functions]
        return np.any(above, axis=0) if above else np.ones(len(table), bool)


def saliency(
    sequence: PosedSequence, p: SceneSaliency, given: Sequence[Learnt] = (), seed: int = 0, progress: Progress = silent
) -> Arrays:
    """The fields of a `saliency` artefact. `given` functions are applied as they are; without, one is learnt from the
    recording's own points of regard and each subsequence predicted by one that has not seen it.

    NoSolution where no subsequence has a surface.
    """
    start = sequence.load(0)
    origin = np.linalg.inv(start.cam_from_world)[:3, 3]

    kept: dict[int, Prepared | str] = {}  # not the latest: the second pass begins with the first ones again

    def prepare(number: int) -> Prepared | str:
        found = kept[number] if number in kept else _prepared(sequence, number, origin, p)
        if number < KEPT:
            kept[number] = found
        return found

    rows = _sampled(sequence, prepare, p, seed, progress)
    notes = [*sequence.notes]
    judge, learnt = (CrossPredictor({}, tuple(given)), {}) if given else _judge(rows, origin, p, seed, notes)
    found = _Found(sequence, p, judge, origin)
    for number in range(sequence.count):
        prepared = prepare(number)
        if isinstance(prepared, str):
            notes.append(prepared)
        else:
            found.add(prepared)
        progress(0.5 + 0.5 * (number + 1) / sequence.count, f"subsequence {number}")
    if not found.scores:
        raise NoSolution(f"no surface in any of {sequence.count} subsequences; the first: {notes[-1]}")
    return found.arrays() | learnt | {
        "notes": np.array(notes, dtype=np.str_).reshape(-1), "source": np.array(sequence.source)
    }  # fmt: skip


def _prepared(sequence: PosedSequence, number: int, origin: np.ndarray, p: SceneSaliency) -> Prepared | str:
    """The subsequence, or why it has no surface."""
    sub = sequence.load(number)
    pose = sub.cam_from_world
    try:
        plate = surface.fit(sub.cloud @ pose[:3, :3].T + pose[:3, 3], p.surface)
    except ParameterError as error:
        return f"subsequence {number}: {error}"
    nodes = features.of_nodes(sub, plate, sequence.camera, origin, p.membranes)
    return Prepared(sub, nodes, regions.labels(nodes.points, sub.regards, sequence.regards, p.radius), plate.error)


@dataclass(frozen=True, eq=False)
class Rows:
    """Sampled points: attended ones and others that nobody ever looked at."""

    table: np.ndarray
    labels: np.ndarray
    subsequence: np.ndarray


def _sampled(sequence: PosedSequence, prepare, p: SceneSaliency, seed: int, progress: Progress) -> Rows:
    """As many points of each subsequence, half of them attended where there are as many."""
    quota = max(p.classifying.most // (2 * sequence.count), 25)
    tables, labels, numbers = [np.empty((0, features.COUNT), np.float32)], [np.empty(0, int)], [np.empty(0, int)]
    for number in range(sequence.count if len(sequence.regards) else 0):
        prepared = prepare(number)
        progress(0.5 * (number + 1) / sequence.count, f"surface of subsequence {number}")
        if isinstance(prepared, str) or not (prepared.labels > 0).any():
            continue
        draw = rng.stream(seed, "saliency sample", str(number))
        for sign in (1, -1):
            mine = np.flatnonzero(prepared.labels == sign)
            chosen = draw.permutation(mine)[:quota]
            tables.append(prepared.nodes.table[chosen])
            labels.append(np.full(len(chosen), sign))
            numbers.append(np.full(len(chosen), number))
    return Rows(np.concatenate(tables), np.concatenate(labels), np.concatenate(numbers))


def _judge(
    rows: Rows, origin: np.ndarray, p: SceneSaliency, seed: int, notes: list[str]
) -> tuple[CrossPredictor, Arrays]:
    """Learn from the recording itself, cross-validated."""
    if len(np.unique(rows.subsequence)) < 2 or len(np.unique(rows.labels)) < 2:
        notes.append("nothing is learnt: that takes points of regard in two subsequences. Membranes alone predict")
        return CrossPredictor({}, ()), {}
    groups = classifier.groups_used(p.classifying)
    folds = classifier.folds_of(rows.subsequence, p.classifying, rng.stream(seed, "saliency folds", ""))
    draw = rng.stream(seed, "saliency landmarks", "")
    margins, by_fold = classifier.cross_validated(
        rows.table, rows.labels, folds, groups, p.radius, p.classifying, draw
    )  # fmt: skip
    whole = classifier.learn(rows.table, rows.labels, groups, p.radius, p.classifying, draw)
    known = np.isfinite(margins)
    if known.any() and len(np.unique(rows.labels[known])) == 2:
        whole = classifier.calibrated(whole, margins[known], rows.labels[known])
    by_fold = {fold: _like(function, whole) for fold, function in by_fold.items()}
    functions: dict[int, tuple[Learnt, ...]] = {}
    if p.classifying.split == "subsequence":
        for number in np.unique(rows.subsequence):
            fold = int(folds[rows.subsequence == number][0])
            functions[int(number)] = (by_fold.get(fold, whole),)
    else:
        notes.append("random split: points of one region lie on both sides, so the error rates flatter")
    table = worth.table(rows.table, rows.labels, rows.subsequence, folds, margins, groups, p, seed)
    return CrossPredictor(functions, (whole,)), table | model_arrays(whole)


def _like(function: Learnt, whole: Learnt) -> Learnt:
    return replace(function, slope=whole.slope, threshold=whole.threshold)


class _Found:
    """What is gathered from subsequence to subsequence."""

    def __init__(self, sequence: PosedSequence, p: SceneSaliency, judge: CrossPredictor, origin: np.ndarray):
        self.sequence, self.p, self.judge, self.origin = sequence, p, judge, origin
        self.cloud = GatheredCloud(4)
        self.subsequences: list[tuple] = []
        self.scores: list[np.ndarray] = []
        self.objects: list[tuple] = []
        self.places: list[np.ndarray] = []
        self.pictures: list[tuple] = []
        self.excited: list[tuple[float, float, float]] = []
        self.regards: list[np.ndarray] = []
        self.outlines: list[np.ndarray] = []
        self.extents: list[np.ndarray] = []
        self.every = max(1, -(-sequence.count * 3 // SHOWN))

    def add(self, prepared: Prepared) -> None:
        """Predict a subsequence."""
        sub, nodes, p = prepared.sub, prepared.nodes, self.p
        learnt = self.judge.saliency(sub.number, nodes.table)
        excited = nodes.membrane
        if p.excitation == "learnt" and np.isfinite(learnt).all():
            excited = features.excited(nodes.membrane, learnt)
        window = max(sub.times[1] - sub.times[0], 1e-3)
        energy = membranes.energies(excited.sigma, excited.z, excited.radius, window, p.membranes)
        if p.domain == "limited":
            energy = np.where(self._within_domain(sub.number, nodes), energy, 0.0)
        shown = learnt if np.isfinite(learnt).all() else _ranks(energy)
        self.cloud.add(nodes.points, np.stack([shown, energy, prepared.labels > 0, nodes.table[:, 3]], axis=1))
        self.scores.append(worth.of_subsequence(nodes.table, prepared.labels, learnt, energy))
        shares = [float((prepared.labels >= least).mean()) for least in (1, 0)]
        self.subsequences.append(
            (*sub.frames, len(sub.regards), len(nodes.points), *sub.times, prepared.error, *shares, sub.number)
        )
        found = proto_objects.find(energy, nodes.points, nodes.place, nodes.grid, p.radius, p.objects)
        first = len(self.objects)
        for item in found:
            hit = HITS[int(prepared.labels[item.node])] if len(self.sequence.regards) else -1
            self.objects.append((sub.number, hit, item.energy, float(shown[item.patch].mean()), *sub.times))
            self.places.append(nodes.points[item.node])
            self.excited.append((excited.sigma[item.node], excited.z[item.node], excited.radius[item.node]))
        self._draw(prepared, shown, [item.patch for item in found], first)

    def _within_domain(self, number: int, nodes: features.NodeFeatures) -> np.ndarray:
        """Nodes in the task domain, and in that which the learnt function elicits where it excites the membranes."""
        domain = self.judge.domain()
        allowed = np.ones(len(nodes.points), bool)
        if domain is not None:
            allowed &= features.inside(nodes.points - self.origin, domain)
        if self.p.excitation == "learnt":
            allowed &= self.judge.elicited(number, nodes.table)
        return allowed

    def _draw(self, prepared: Prepared, shown: np.ndarray, patches: list[np.ndarray], first: int) -> None:
        """Maps, points of regard and outlines in the pictures of a subsequence."""
        camera, points = self.sequence.camera, prepared.nodes.points
        for shot in prepared.sub.snapshots:
            cells = regions.nodes_in_picture(camera, shot.cam_from_world, points)
            seen = cells >= 0
            if not seen.any():
                continue
            if len(prepared.sub.regards):
                self.extents.append(np.array([prepared.sub.number, (seen & (prepared.labels[cells] > 0)).mean()]))
            if prepared.sub.number % self.every or len(self.pictures) >= SHOWN:
                continue
            number = len(self.pictures)
            near = np.abs(self.sequence.regard_frames - shot.frame) <= NEAR
            pixels = seen_at(camera, shot.cam_from_world, self.sequence.regards[near])
            pixels = pixels[np.isfinite(pixels[:, 0])]
            self.regards.append(np.concatenate([np.full((len(pixels), 1), number), pixels], axis=1))
            self.pictures.append((shot.frame, prepared.sub.number, shot.image, regions.shown(shown, cells)))
            for k, patch in enumerate(patches):
                rim = _outline(seen & patch[cells])
                self.outlines.append(np.concatenate([np.tile([first + k, number], (len(rim), 1)), rim], axis=1))

    def arrays(self) -> Arrays:
        """The fields, but for what was learnt."""
        return _scene_arrays(self)


def _ranks(values: np.ndarray) -> np.ndarray:
    from scipy.stats import rankdata

    return rankdata(values) / len(values)


def _outline(mask: np.ndarray) -> np.ndarray:
    """(n, 2) pixels along the rim of the largest part of a mask of cells."""
    import cv2

    contours, _ = cv2.findContours(mask.astype(np.uint8), cv2.RETR_EXTERNAL, cv2.CHAIN_APPROX_NONE)
    if not contours:
        return np.empty((0, 2))
    largest = max(contours, key=len)[:, 0]
    return largest * float(regions.CELL) + (regions.CELL - 1) / 2


def _scene_arrays(f: _Found) -> Arrays:
    sub = np.array(f.subsequences)
    objects = np.array(f.objects).reshape(-1, 6)
    places = np.array(f.places).reshape(-1, 3)
    rows = f.cloud.rows
    scores = np.array(f.scores)
    arrays: Arrays = {
        "subsequences/frames": sub[:, :2].astype(np.int64),
        "subsequences/regards": sub[:, 2].astype(np.int64),
        "subsequences/nodes": sub[:, 3].astype(np.int64),
        "subsequences/times": sub[:, 4:6],
        "subsequences/error": sub[:, 6],
        "subsequences/attended": sub[:, 7:9],
        "subsequences/ranking": scores,
        "points/places": rows[:, :3].astype(np.float32),
        "points/saliency": rows[:, 3].astype(np.float32),
        "points/energy": rows[:, 4].astype(np.float32),
        "points/attended": rows[:, 5].astype(np.float32),
        "points/curvature": rows[:, 6].astype(np.float32),
        "objects/places": places,
        "objects/subsequence": objects[:, 0].astype(np.int64),
        "objects/hit": objects[:, 1].astype(np.int64),
        "objects/energy": objects[:, 2],
        "objects/saliency": objects[:, 3],
        "objects/times": objects[:, 4:6],
        "objects/track": proto_objects.lasting(places, objects[:, 0], f.p.radius).astype(np.int64),
        "hits": _hits(objects, sub),
        "rankings": np.array(worth.RANKED),
        "extents": np.array(f.extents).reshape(-1, 2),
        "radius": np.array(f.p.radius, np.float64),
    }
    strongest = np.argsort(-objects[:, 2], kind="stable")[:STRONGEST]
    window = float((sub[:, 5] - sub[:, 4]).mean())
    vibrating = membranes.shown(np.array(f.excited).reshape(-1, 3)[strongest], window, f.p.membranes)
    return arrays | _picture_arrays(f) | vibrating


def _hits(objects: np.ndarray, sub: np.ndarray) -> np.ndarray:
    """Share of proto-objects looked at in their subsequence and ever, and of nodes of the subsequences they are in."""
    judged = objects[objects[:, 1] >= 0]
    if not len(judged):
        return np.full((2, 2), np.nan)
    place = {number: row for row, number in enumerate(np.unique(sub[:, 9]))}
    chance = sub[[place[number] for number in judged[:, 0]], 7:9].mean(axis=0)
    return np.stack([[(judged[:, 1] >= least).mean() for least in (2, 1)], chance], axis=1)


def _picture_arrays(f: _Found) -> Arrays:
    regards = np.concatenate([*f.regards, np.empty((0, 3))])
    outlines = np.concatenate([*f.outlines, np.empty((0, 4))])
    return {
        "pictures/frames": np.array([row[0] for row in f.pictures], np.int64),
        "pictures/subsequence": np.array([row[1] for row in f.pictures], np.int64),
        "pictures/images": np.stack([row[2] for row in f.pictures]),
        "pictures/maps": np.stack([row[3] for row in f.pictures]),
        "regards/picture": regards[:, 0].astype(np.int64),
        "regards/pixels": np.ascontiguousarray(regards[:, 1:]),
        "outlines/object": outlines[:, 0].astype(np.int64),
        "outlines/picture": outlines[:, 1].astype(np.int64),
        "outlines/pixels": np.ascontiguousarray(outlines[:, 2:]),
    }


MODEL = {
    "columns": np.int64, "centre": np.float64, "scale": np.float64, "supports": np.float64, "weights": np.float64,
    "gamma": np.float64, "offset": np.float64, "slope": np.float64, "threshold": np.float64, "domain": np.float64,
}  # fmt: skip


def model_arrays(function: Learnt) -> Arrays:
    """The learnt function as fields."""
    return {f"model/{name}": np.asarray(getattr(function, name), dtype) for name, dtype in MODEL.items()}


def model_of(arrays: Arrays) -> Learnt | None:
    """The learnt function of an artefact's fields; None where nothing was learnt."""
    if "model/columns" not in arrays:
        return None
    values: dict[str, Any] = {name: arrays[f"model/{name}"] for name in MODEL}
    values |= {name: float(values[name]) for name in ("gamma", "offset", "threshold")}
    return Learnt(**values)
