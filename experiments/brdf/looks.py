"""Which material a picture shows, told by the codes of its patches (thesis 7.2) and by colour and statistics.

Surfaces and probes of the pictures asked about are not among those that the coders are taught on, nor among those that
their distances are standardised by.
"""

from __future__ import annotations

from collections.abc import Iterable, Iterator
from dataclasses import dataclass
from tempfile import TemporaryFile
from typing import BinaryIO

import numpy as np

from ipcli.models.brdf import autoencoder, divergence, material
from ipcli.models.brdf import scenes as generated
from ipcli.models.brdf.library import Library
from ipcli.models.brdf.parameters import Coding
from ipcli.models.brdf.solid import pictured
from ipcli.rng import stream

SIDE = 96  # of the pictures
PATCH, EACH = 7, 200  # side of a patch, patches of a picture
PICTURES = {"taught": 24, "held": 48, "asked": 24}  # of each material
QUICK = {"taught": 2, "held": 2, "asked": 2}
FEW = Coding(iterations=8)
MEASURES = (*divergence.ORDERS, "error")
WAYS = {
    "divergence as printed": ("printed",),
    "divergence, the mean last": ("fixed",),
    "error of reading back": ("error",),
    "divergence and error": ("fixed", "error"),
}
LEARNT = {  # linear discriminants, learnt on the held-out pictures
    "divergence and error, learnt": ("fixed", "error"),
    "colour and statistics, learnt": ("statistics",),
    "all of these, learnt": ("fixed", "error", "statistics"),
}
LIBRARY = "colour and statistics, the library's"  # it has seen these probes


def shares(shelf: Library, metals: np.ndarray, quick: bool) -> dict[str, tuple[float, float]]:
    """Of each way of telling, the shares of pictures whose material and whose being metal or not (b,) are right."""
    counts = QUICK if quick else PICTURES
    coding = FEW if quick else Coding()
    looks = [look(shelf, index, counts, coding) for index in range(len(shelf.materials))]
    held, asked = (seen(shelf, looks, use, counts[use]) for use in ("held", "asked"))
    answers = {name: np.argmin(asked.far(measures), axis=1) for name, measures in WAYS.items()}
    for name, groups in LEARNT.items():
        learnt = material.learn(held.features(groups), held.truth, len(shelf.materials))
        answers[name] = learnt.posterior(asked.features(groups)).argmax(axis=1)
    answers[LIBRARY] = shelf.classifier.posterior(asked.statistics).argmax(axis=1)
    right = asked.truth
    return {
        name: (float((told == right).mean()), float((metals[told] == metals[right]).mean()))
        for name, told in answers.items()
    }


@dataclass(frozen=True, eq=False)
class Seen:
    """What is seen of n pictures of b materials."""

    truth: np.ndarray  # (n,) index of the material
    measures: dict[str, np.ndarray]  # (n, b) how far the patches are from each material
    statistics: np.ndarray  # (n, f) of the whole picture

    def far(self, measures: tuple[str, ...]) -> np.ndarray:
        """Some measures added (n, b)."""
        return np.sum([self.measures[measure] for measure in measures], axis=0)

    def features(self, groups: tuple[str, ...]) -> np.ndarray:
        """What a classifier learns from, side by side (n, .): measures by their names, or `statistics`."""
        parts = [self.statistics if group == "statistics" else self.measures[group] for group in groups]
        return np.concatenate(parts, axis=1)


def seen(shelf: Library, looks: list[divergence.Look], use: str, count: int) -> Seen:
    """All pictures of a use, of every material."""
    truth, rows = [], []
    measures: dict[str, list[list[float]]] = {name: [] for name in MEASURES}
    for index in range(len(shelf.materials)):
        for picture, mask in pictures(shelf, index, use, count):
            patches = autoencoder.patches(picture, mask, PATCH, EACH)
            for name, lines in measures.items():
                lines.append([one.far(patches, name) for one in looks])
            rows.append(material.statistics(pictured(picture, mask, 72)))
            truth.append(index)
    return Seen(np.array(truth), {name: np.array(lines) for name, lines in measures.items()}, np.array(rows))


def look(shelf: Library, index: int, counts: dict[str, int], coding: Coding) -> divergence.Look:
    """The coder of a material, and how far its own held-out pictures are from it."""

    def patches(use: str) -> Iterator[np.ndarray]:
        return (autoencoder.patches(*seen, PATCH, EACH) for seen in pictures(shelf, index, use, counts[use]))

    with TemporaryFile() as file:
        taught = spooled(patches("taught"), file)
        coder = autoencoder.learn(taught, coding, stream(11, "look", shelf.materials[index]))
        return divergence.look(coder, taught, list(patches("held")))


def spooled(parts: Iterable[np.ndarray], file: BinaryIO) -> autoencoder.Batches:
    """Rows (m, d) that come in parts, put into a file; read again in batches, so that they are never all in memory."""
    width = 0
    for part in parts:
        width = part.shape[1]
        file.write(part.tobytes())

    def batches() -> Iterator[np.ndarray]:
        file.seek(0)
        while read := file.read(8 * width * autoencoder.BATCH):
            yield np.frombuffer(read).reshape(-1, width)

    return batches


def pictures(shelf: Library, index: int, use: str, count: int) -> Iterator[tuple[np.ndarray, np.ndarray]]:
    """Linear pictures of a material and their masks; each use has a third of the probes and surfaces of its own."""
    third = list(PICTURES).index(use)
    charts = np.flatnonzero((shelf.material == index) & (shelf.probe % 3 == third))
    for number in range(count):
        rng = stream(11, "looks", f"{use} {number}")
        surface = generated.surface(rng, SIDE, sheets=0.25)
        yield generated.photograph(surface, shelf.charts[int(rng.choice(charts))], rng), surface.mask
