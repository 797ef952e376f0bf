"""Figure 6.3, masks lifted with the load, without, with noise: `python -m experiments.animal.aspects.page OUT.html`.

Each part of a labelled mesh is seen from the left by itself; the truth is half the distance between its nearest and its
farthest face along each ray. All parts are in pixels of one image of the animal, as the thesis has it ("keeping the
proportions of the components"). The error of a load is the mean of |half thickness - gain * height| over the part's
diagonal, with one gain for all parts, fitted in L1. "Without" is a constant load: with none at all the surface
stays flat.
"""

from __future__ import annotations

import argparse
import json
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any

import numpy as np

from experiments.animal import meshes, trial
from ipcli.geometry.orthographic import looking
from ipcli.geometry.part_masks import first_faces, framed
from ipcli.io.files import atomic
from ipcli.models.animal.aspects import inflate
from ipcli.models.animal.parameters import LOADS, Inflation
from ipcli.report.kit.page import figure, gallery, section, table
from ipcli.report.kit.page import page as document
from ipcli.report.kit.pictures import photograph

NAMES = ("381", "387", "388", "390", "391", "394", "395", "396", "397", "399", "400")
LONGEST = 350  # pixels of the longer side of the animal
LEAST = 150  # pixels, and half of all, in which a part that is counted has two sides: where it was cut off it has one
NOISES = (1.0, 2.0)  # pixels
SHOWN = "front_leg_L"  # the thesis shows a leg of a cat
NOTES = {"constant": "constant: without the load", "printed": "printed: (6.4) as it stands"}


@dataclass(frozen=True, eq=False)
class LabelledPart:
    """A part from the left: its mask (h, w), half thickness (h, w) in pixels, and its diagonal in pixels."""

    name: str
    mask: np.ndarray
    half: np.ndarray
    diagonal: float
    turned: np.ndarray  # its mask with the camera rolled by 45 degrees, in pixels of one size


def parts_of(animal: meshes.Animal, each_alike: bool = False) -> list[LabelledPart]:
    """All parts of an animal that are large enough, in pixels of one image; `each_alike`: each of them as large in an
    image of its own as the animal would be.
    """
    found = []
    for number, name in enumerate(animal.tree.names, start=1):
        used, faces = np.unique(animal.faces[animal.labels == number], return_inverse=True)
        vertices, faces = animal.vertices[used], faces.reshape(-1, 3)
        camera, shape = framed(vertices if each_alike else animal.vertices, looking(90.0, 0.0), LONGEST)
        _, near = first_faces(vertices, faces, camera, shape)
        flipped = replace(camera, rotation=np.diag([1.0, 1.0, -1.0]) @ camera.rotation)
        _, far = first_faces(vertices, faces, flipped, shape)
        half = np.nan_to_num((-far - near) / 2 * camera.scale)
        rolled = replace(camera, rotation=looking(90.0, 0.0, 45.0))
        size = 2 * LONGEST
        middle = rolled.rotation[:2] @ (vertices.min(axis=0) + vertices.max(axis=0)) / 2
        _, seen = first_faces(vertices, faces, replace(rolled, shift=size / 2 - camera.scale * middle), (size, size))
        diagonal = float(np.linalg.norm(np.ptp(vertices, axis=0))) * camera.scale
        if (half > 0).sum() >= max(LEAST, np.isfinite(near).sum() / 2):
            part, box = f"{animal.name} {name}", around(np.isfinite(near))
            turned = np.isfinite(seen)
            found.append(LabelledPart(part, np.isfinite(near)[box], half[box], diagonal, turned[around(turned)]))
    return found


def around(mask: np.ndarray, margin: int = 8) -> tuple[slice, slice]:
    """The box of a mask with some pixels to spare."""
    down, across = (slice(max(int(at.min()) - margin, 0), int(at.max()) + margin + 1) for at in np.nonzero(mask))
    return down, across


def gain(parts: list[LabelledPart], heights: list[np.ndarray]) -> float:
    """The one factor that makes the mean error of all parts least: a weighted median."""
    ratios, weights = [], []
    for part, height in zip(parts, heights, strict=True):
        told = (part.half > 0) & (height > 0)
        ratios.append(part.half[told] / height[told])
        weights.append(height[told] / ((part.half > 0).sum() * part.diagonal))
    order = np.argsort(np.concatenate(ratios))
    total = np.cumsum(np.concatenate(weights)[order])
    return float(np.concatenate(ratios)[order][np.searchsorted(total, total[-1] / 2)])


def error(part: LabelledPart, height: np.ndarray) -> float:
    """Mean of |half thickness - height| where the part has two sides, over the diagonal."""
    return float(np.abs(part.half - height)[part.half > 0].mean() / part.diagonal)


def measure(parts: list[LabelledPart], load: str, triangles: int) -> dict[str, Any]:
    """Errors of one load without noise and with, by one gain, and what a turn of the mask by 45 degrees changes."""
    params = Inflation(load=load, triangles=triangles)
    lifted = [inflate(part.mask, params).picture for part in parts]
    factor = gain(parts, lifted)
    shown = [part for part in parts if part.name.endswith(SHOWN)]
    noisy = {
        f"{noise:g}": float(np.mean([error(part, factor * lifted_noisy(part, noise, params)) for part in shown]))
        for noise in NOISES
    }
    still = [lifted[parts.index(part)] for part in shown]
    volumes = [inflate(p.turned, params).picture.sum() / lift.sum() - 1 for p, lift in zip(shown, still, strict=True)]
    return {
        "gain": factor,
        "error": float(np.mean([error(part, factor * lift) for part, lift in zip(parts, lifted, strict=True)])),
        "shown": float(np.mean([error(part, factor * lift) for part, lift in zip(shown, still, strict=True)])),
        "noisy": noisy,
        "turned": float(np.abs(volumes).max()),
    }  # fmt: skip


def lifted_noisy(part: LabelledPart, noise: float, params: Inflation) -> np.ndarray:
    """Heights of the part's mask with so many pixels of contour noise."""
    labels = trial.jagged(part.mask.astype(np.int16), noise, np.random.default_rng(0))
    return inflate(labels > 0, params).picture


def pictures(part: LabelledPart, results: dict[str, dict], triangles: int):
    """Depth maps of one part: the truth, each load, and each with noise."""
    shots = [("truth", part.half)]
    for load in results:
        params = Inflation(load=load, triangles=triangles)
        shots.append((NOTES.get(load, load), results[load]["gain"] * inflate(part.mask, params).picture))
        shots.append(
            (f"{load}, noise of {NOISES[-1]:g} px", results[load]["gain"] * lifted_noisy(part, NOISES[-1], params))
        )
    most = part.half.max()
    grey = [(name, (255 * np.clip(height / most, 0, 1)).astype(np.uint8)) for name, height in shots]
    return [figure(photograph(np.repeat(shot[..., None], 3, axis=2), 300), name) for name, shot in grey]


def main() -> None:
    """The command line."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("out", type=Path)
    parser.add_argument("--data", type=Path, default=Path("../shared/data"))
    parser.add_argument("--cache", type=Path, default=Path("build/meshes/animal"))
    parser.add_argument("--only", default=",".join(NAMES), help="names of animals, with commas")
    parser.add_argument("--each-alike", action="store_true", help="each part as large as the animal")
    parser.add_argument("--quick", action="store_true", help="one generated animal, few triangles")
    given = parser.parse_args()
    given.out.parent.mkdir(parents=True, exist_ok=True)
    triangles = 200 if given.quick else 600
    if given.quick:
        animals = [meshes.generated()]
    else:
        cache = meshes.unpack(given.data, given.cache)
        animals = [meshes.load(cache, name) for name in given.only.split(",")]
    parts = [part for animal in animals for part in parts_of(animal, given.each_alike)]
    results = {load: measure(parts, load, triangles) for load in LOADS}
    rows = [
        (load, *(f"{value:.4f}" for value in (result["error"], result["gain"], result["shown"])),
         *(f"{value:.4f}" for value in result["noisy"].values()), f"{100 * result['turned']:.1f} %")
        for load, result in results.items()
    ]  # fmt: skip
    leg = next(part for part in parts if part.name.endswith(SHOWN))
    head = (
        "load",
        f"{len(parts)} parts",
        "gain",
        "left front legs",
        *(f"noise {n:g} px" for n in NOISES),
        "turned by 45°",
    )
    atomic.write_text(
        given.out.with_suffix(".json"), json.dumps({"parts": len(parts), "loads": results}, indent=1) + "\n"
    )
    atomic.write_text(given.out, document(
        "What lifts a mask", "thesis 6.3.1, figure 6.3",
        "Mean error of half thickness over the part's diagonal, one gain a load for all parts; last column: how "
        "much the volume of a leg changes, at the most, when its mask is turned.",
        section("Loads", table(head, rows)),
        section(f"Depth maps of {leg.name}", gallery(*pictures(leg, results, triangles), columns=3),
                lead="Bright: thick; all at one scale."),
    ))  # fmt: skip
    for row in rows:
        print(*row)
    print(given.out)


if __name__ == "__main__":
    main()
