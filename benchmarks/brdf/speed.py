"""Seconds of chapter 7: a photograph from its files to its surface, the coder of a material, and what an order saves.

python -m benchmarks.brdf.speed [--library FILE]     without a library a small one is made first
python -m benchmarks.brdf.speed --quick              small pictures and few patches
"""

from __future__ import annotations

import tempfile
from collections.abc import Sequence
from pathlib import Path
from typing import Any

import numpy as np

from benchmarks.kit.arguments import add_threads, parser_of
from benchmarks.kit.measure import Clock, attempted, forget_peak, peak_memory
from benchmarks.kit.publish import publish

SIDES = (256, 512)
PATCHES = (20_000, 200_000)  # the second is a material
PART = 1_000  # patches made at once
PATCH = 9  # pixels of its side
QUICK_SIDES, QUICK_PATCHES = (96,), (2_000,)
RUNS = 5


def photograph(library: str, side: int, rim: str) -> dict[str, Any]:
    """brdf-model on a generated picture that fills a square of this side, files read and written, pages included."""
    from ipcli.models.brdf.parameters import Inference
    from ipcli.params import Run
    from ipcli.stages.brdf import brdf_model
    from ipcli.stages.brdf.parameters import BrdfModel

    with tempfile.TemporaryDirectory() as place:
        photo, mask = pictured(Path(place), Path(library), side)
        source = brdf_model.ObjectFiles(Path(library), photo, mask)
        start, clock = forget_peak(), Clock()
        with clock:
            brdf_model.run(source, Path(place) / "object.h5", BrdfModel(inference=Inference(rim=rim)), Run())
        seconds = {"seconds": clock.last, "CPU s": clock.processor, "peak MB": peak_memory() - start}
    return {"picture": f"{side} x {side}", "taken for a": rim} | seconds


def pictured(folder: Path, library: Path, side: int) -> tuple[Path, Path]:
    """A generated vase in the first material of a library under its first light: picture and mask as PNG."""
    from experiments.brdf import scenes
    from ipcli.io.files import h5, images
    from ipcli.models.brdf.scenes import photograph as take

    chart = h5.read(library, "brdf-library", lambda name: name == "charts").arrays["charts"][0]
    made = scenes.own(side)["vase"]
    taken = take(made, chart, np.random.default_rng(0))
    paths = folder / "vase.png", folder / "vase.mask.png"
    images.write_png(paths[0], np.rint(255 * taken ** (1 / 2.2)).astype(np.uint8))
    images.write_png(paths[1], np.where(made.mask, 255, 0).astype(np.uint8))
    return paths


def coder(patches: int) -> dict[str, Any]:
    """The stacked sparse autoencoder of a material from so many patches in a file."""
    from experiments.brdf.looks import spooled
    from ipcli.models.brdf import autoencoder
    from ipcli.models.brdf.parameters import Coding

    rng, width = np.random.default_rng(0), 3 * PATCH**2
    few = rng.normal(size=(8, width))
    sizes = [min(PART, patches - start) for start in range(0, patches, PART)]
    with tempfile.TemporaryFile() as file:
        made = (rng.normal(size=(m, 8)) @ few + 0.1 * rng.normal(size=(m, width)) for m in sizes)
        taught = spooled(made, file)
        start, clock = forget_peak(), Clock()
        with clock:
            autoencoder.learn(taught, Coding(), rng)
    told = {"seconds": clock.last, "CPU s": clock.processor, "peak MB": peak_memory() - start}
    return {"patches": patches, "numbers each": width} | told


def order(side: int) -> dict[str, Any]:
    """One factorisation of a Gauss-Newton step on a disc of this side: ours against SciPy's default order."""
    from scipy.sparse.linalg import splu

    from ipcli.models.brdf.energy import factor
    from ipcli.models.brdf.grid import grid

    axis = (np.arange(side) + 0.5) / side * 2 - 1
    cells = grid(np.hypot(axis[:, None], axis) < 1)
    matrix = sum(b.T @ b for b in (cells.slope_x, cells.slope_y, *cells.bend)).tocsc()
    matrix.setdiag(matrix.diagonal() + 1e-6)
    ours, default = (_least(work) for work in (lambda: factor(matrix), lambda: splu(matrix)))
    return {"unknowns": cells.size, "ours [ms]": 1e3 * ours, "default [ms]": 1e3 * default, "times": default / ours}


def _least(work: Any) -> float:
    clock = Clock()
    return min(_timed(work, clock) for _ in range(RUNS))


def _timed(work: Any, clock: Clock) -> float:
    with clock:
        work()
    return clock.last


def small_library(folder: Path) -> Path:
    """The library of the sample's materials, from few lights and scenes."""
    from ipcli.models.brdf.parameters import LibraryLearning
    from ipcli.params import Run
    from ipcli.stages.brdf import brdf_train
    from ipcli.stages.brdf.parameters import BrdfTrain

    path = folder / "library.h5"
    few = BrdfTrain(learning=LibraryLearning(lights=12, scenes=120, pictures=40))
    brdf_train.run(Path("sample_data/brdf/materials.toml"), path, few, Run())
    return path


def main(arguments: Sequence[str] | None = None) -> None:
    """Measure, write and print."""
    parser = parser_of(__doc__, "small pictures and few patches")
    parser.add_argument("--library", type=Path, help="of brdf-train; a small one is made if none is given")
    add_threads(parser)
    given = parser.parse_args(arguments)
    sides, counts = (QUICK_SIDES, QUICK_PATCHES) if given.quick else (SIDES, PATCHES)
    with tempfile.TemporaryDirectory() as place:
        library = str(given.library.resolve() if given.library else small_library(Path(place)))
        here = "benchmarks.brdf.speed"
        tables = {
            "A photograph": [
                attempted(f"{here}:photograph", given.threads, library=library, side=side, rim=rim)
                for side in sides
                for rim in ("solid", "sheet")
            ],
            "The coder of a material": [attempted(f"{here}:coder", given.threads, patches=m) for m in counts],
            "Factorisation of a step": [attempted(f"{here}:order", 1, side=side) for side in (32, 72)],
        }
    publish("brdf_speed", "Surfaces from one picture", tables, {"threads": given.threads}, given.output)


if __name__ == "__main__":
    main()
