"""Which material a picture shows, told by the codes of its patches (thesis 7.2) and by colour and statistics.

Surfaces and probes of the pictures asked about are not among those that the coders are taught on, nor among those that
their distances are standardised by.
"""

from __future__ import annotations

from collections.abc import Iterable, Iterator
from tempfile import TemporaryFile
from typing import BinaryIO

import numpy as np

from ipcli.models.brdf import autoencoder, divergence
from ipcli.models.brdf import scenes as generated
from ipcli.models.brdf.library import Library
from ipcli.models.brdf.material import statistics
from ipcli.models.brdf.parameters import Coding
from ipcli.models.brdf.solid import pictured
from ipcli.rng import stream

SIDE = 96  # of the pictures
PATCH, EACH = 7, 200  # side of a patch, patches of a picture
PICTURES = {"taught": 24, "held": 12, "asked": 24}  # of each material
QUICK = {"taught": 2, "held": 2, "asked": 2}
FEW = Coding(iterations=8)
WAYS = {
    "divergence as printed": ("printed",),
    "divergence, the mean last": ("fixed",),
    "error of reading back": ("error",),
    "divergence and error": ("fixed", "error"),
}


def shares(shelf: Library, metals: np.ndarray, quick: bool) -> dict[str, tuple[float, float]]:
    """Of each way of telling, the shares of pictures whose material and whose being metal or not (b,) are right."""
    counts = QUICK if quick else PICTURES
    coding = FEW if quick else Coding()
    looks = [look(shelf, index, counts, coding) for index in range(len(shelf.materials))]
    answers: dict[str, list[int]] = {name: [] for name in (*WAYS, "colour and statistics")}
    truth = []
    for index in range(len(shelf.materials)):
        for picture, mask in pictures(shelf, index, "asked", counts["asked"]):
            truth.append(index)
            patches = autoencoder.patches(picture, mask, PATCH, EACH)
            for name, measures in WAYS.items():
                answers[name].append(divergence.nearest(looks, patches, measures))
            posterior = shelf.classifier.posterior(statistics(pictured(picture, mask, 72)))
            answers["colour and statistics"].append(int(posterior.argmax()))
    right = np.array(truth)
    return {
        name: (float((told == right).mean()), float((metals[told] == metals[right]).mean()))
        for name, told in ((name, np.array(found)) for name, found in answers.items())
    }


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
