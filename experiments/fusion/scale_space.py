"""How the confidence sets the scale (thesis figures 4.1 and 4.2), as arrays: `python scale_space.py OUT.npz`.

Boxes of several sizes and heights under TV-L1, by an even confidence c and by one that varies in space (4.1); depth
maps of which one half is three times as noisy, fused with even and with estimated confidences (4.2).
"""

import sys
from pathlib import Path

import numpy as np

from ipcli.inverse.regularize import tgv
from ipcli.inverse.regularize.fidelity import AbsoluteDeviations, Observations
from ipcli.inverse.regularize.parameters import Regulariser, Solver
from ipcli.io.files import npz
from ipcli.measurements.views import View
from ipcli.models.fusion.fuse import fuse
from ipcli.models.fusion.parameters import Confidence, Fusion

SIZE = 128
BOXES = (
    (6, 6, 6, 1.0),
    (6, 22, 10, 0.4),
    (6, 44, 16, 0.8),
    (50, 8, 26, 0.5),
    (46, 62, 44, 1.0),
)  # row, column, side, height
EVEN = (1.5, 0.5, 0.3, 0.18, 0.1)
SMALLEST, THIRD = BOXES[0], BOXES[2]
VIEWS, NOISE, NOISIER = 11, 0.05, 3.0
LAMBDAS = (0.05, 0.3, 1.5)
PRIORS = {"weak": Confidence(shape=1.5, rate=0.1), "default": Confidence()}  # weak: that of the authors' code


def boxes() -> np.ndarray:
    """Flat boxes (h, w) on flat ground."""
    image = np.zeros((SIZE, SIZE), np.float32)
    for row, column, side, height in BOXES:
        image[row : row + side, column : column + side] = height
    return image


def confidence(inside: float, outside: float, box: tuple) -> np.ndarray:
    """Confidence (h, w): one value in and just around a box, another elsewhere."""
    row, column, side, _ = box
    image = np.full((SIZE, SIZE), outside, np.float32)
    image[max(row - 3, 0) : row + side + 3, max(column - 3, 0) : column + side + 3] = inside
    return image


def regularised(image: np.ndarray, c: np.ndarray) -> np.ndarray:
    """The minimiser (h, w) of TV(x) + sum c |x - image|."""
    fidelity, iterate = AbsoluteDeviations(Observations.of([image]), c), tgv.Iterate.at(image)
    tgv.minimise(fidelity, Regulariser(order=1), iterate, (0.0, 1.0), Solver(tolerance=1e-4, iterations=20000))
    return iterate.x


def scale_space() -> dict[str, np.ndarray]:
    """Figure 4.1."""
    image = boxes()
    panels = {"boxes": image}
    panels |= {f"c = {c:g}": regularised(image, np.full_like(image, c)) for c in EVEN}
    panels["c = 1.5 at the smallest, 0.1 elsewhere"] = regularised(image, confidence(1.5, 0.1, SMALLEST))
    panels["c = 0.1 at the third, 1.5 elsewhere"] = regularised(image, confidence(0.1, 1.5, THIRD))
    return panels


def noisy_fusion() -> dict[str, np.ndarray]:
    """Figure 4.2: a tilted plane with boxes, seen `VIEWS` times from one place; its right half is noisier."""
    rows, columns = np.indices((SIZE, SIZE)) / SIZE
    truth = (3 + 0.4 * rows - 0.3 * columns - 0.5 * boxes()).astype(np.float32)
    noise = np.where(columns < 0.5, NOISE, NOISIER * NOISE)
    rng, camera = np.random.default_rng(0), np.array([[SIZE, 0, SIZE / 2], [0, SIZE, SIZE / 2], [0, 0, 1.0]])
    observed = [(truth + noise * rng.laplace(size=truth.shape)).astype(np.float32) for _ in range(VIEWS)]
    views = [View(str(k), depth, camera, np.eye(4)) for k, depth in enumerate(observed)]
    panels = {"truth": truth, "one view": observed[0]}
    for lam in LAMBDAS:
        panels[f"λ = {lam:g}"] = fuse(
            views, views[0], Fusion(method="tgv-l1", lam=lam, reassociate=0), inverse=False
        ).depth
    for prior in PRIORS.values():
        fused = fuse(views, views[0], Fusion(method="l1-adapt", reassociate=0, confidence=prior), inverse=False)
        about = f"b = K + {prior.shape - 1:g}, 1/(2W) = {prior.rate:g}"
        panels |= {about: fused.depth, f"confidence, {about}": fused.confidence}
    return panels


if __name__ == "__main__":
    figures = (("4.1", scale_space()), ("4.2", noisy_fusion()))
    numbered = {
        f"{figure} {chr(97 + i)} {name}": panel
        for figure, panels in figures
        for i, (name, panel) in enumerate(panels.items())
    }
    npz.write(Path(sys.argv[1]), numbered)
