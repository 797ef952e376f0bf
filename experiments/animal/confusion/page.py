"""Figure 6.6: is a model nearest to its own kind of animal? `python -m experiments.animal.confusion.page OUT.html`.

Each animal is modelled from left, right, front, back and top and held against the ground truth of every animal, all in
boxes of the same middle and diagonal, or stretched to one box; "another of its kind" leaves the animal itself out.
"""

from __future__ import annotations

import argparse
import json
from pathlib import Path

import numpy as np

from experiments.animal import meshes, trial
from experiments.kit.tables import write_table
from ipcli.geometry.distances import to_surface
from ipcli.io.files import atomic, npz
from ipcli.models.animal import whole
from ipcli.models.animal.parameters import Inflation, Modelling, Volume
from ipcli.models.animal.placing import placed
from ipcli.report.kit.page import figure, gallery, section, table
from ipcli.report.kit.page import page as document
from ipcli.report.kit.pictures import draw, robust

VIEWS = trial.SETS["three silhouettes"]
QUICK = Modelling(inflation=Inflation(triangles=300), volume=Volume(voxels=48))
SAMPLES = 4000  # points on each surface
BOXES = ("of one diagonal", "stretched to one box")
Mesh = tuple[np.ndarray, np.ndarray]


def modelled(animal: meshes.Animal, params: Modelling, path: Path) -> Mesh:
    """The model of an animal in the world of the truth, from its file when that is there."""
    if not path.is_file():
        images, truth = map(list, zip(*trial.shots(animal, VIEWS, False), strict=True))
        cameras = placed(images, animal.tree, params)
        surface = whole.model(images, cameras, animal.tree, params)
        vertices = trial.to_truth(surface.vertices, cameras, truth)
        npz.write(path, {"vertices": vertices, "faces": surface.faces})
    found = npz.read(path)
    return found["vertices"], found["faces"]


def boxed(mesh: Mesh, is_stretched: bool) -> Mesh:
    """The mesh with the middle of its box at the origin and the box's diagonal, or each of its sides, of length 1."""
    low, high = mesh[0].min(axis=0), mesh[0].max(axis=0)
    size = high - low if is_stretched else np.linalg.norm(high - low)
    return (mesh[0] - (low + high) / 2) / size, mesh[1]


def distances(found: list[Mesh], truth: list[Mesh]) -> np.ndarray:
    """Mean distances both ways (n, m) of n models and m true animals."""
    import trimesh

    def points(mesh: Mesh) -> np.ndarray:
        body = trimesh.Trimesh(mesh[0], mesh[1], process=False)
        return trimesh.sample.sample_surface(body, SAMPLES, seed=0)[0]

    ours, theirs = [points(mesh) for mesh in found], [points(mesh) for mesh in truth]
    return np.array(
        [
            [
                (to_surface(ours[i], truth[j]).mean() + to_surface(theirs[j], found[i]).mean()) / 2
                for j in range(len(truth))
            ]
            for i in range(len(found))
        ]
    )


def nearest(apart: np.ndarray, names: list[str], kinds: list[str], is_alone: bool) -> list[str | None]:
    """The kind (n,) of the true animal that each model is nearest to; `is_alone`: of all but itself, None for one that
    has no other of its kind.
    """
    found: list[str | None] = []
    for i, kind in enumerate(kinds):
        others = [j for j in range(len(names)) if j != i or not is_alone]
        told = kind in [kinds[j] for j in others]
        found.append(kinds[min(others, key=lambda j: apart[i, j])] if told else None)
    return found


def rows_of(apart: dict[str, np.ndarray], names: list[str], kinds: list[str]) -> list[dict[str, object]]:
    """A row a model: which kind is nearest in either box, with itself and without."""
    columns = {
        f"{box}{', another of its kind' if is_alone else ''}": nearest(apart[box], names, kinds, is_alone)
        for box in BOXES
        for is_alone in (False, True)
    }
    return [
        {"animal": name, "kind": kind} | {column: told[i] for column, told in columns.items()}
        for i, (name, kind) in enumerate(zip(names, kinds, strict=True))
    ]


def page(apart: dict[str, np.ndarray], rows: list[dict[str, object]]) -> str:
    """The matrices as pictures and the rows as a table."""
    columns = [key for key in rows[0] if key not in ("animal", "kind")]
    lines = []
    for column in columns:
        told = [row for row in rows if row[column] is not None]
        right = sum(row[column] == row["kind"] for row in told)
        lines.append((column, f"{right} of {len(told)}"))
    shown = []
    for box, matrix in apart.items():
        large = np.kron(matrix, np.ones((16, 16)))
        scale = robust([large], "viridis")
        shown.append(
            figure(draw(large, scale), box, "rows: models; columns: true animals, in the same order", scale=scale)
        )
    cells = [(str(row["animal"]), str(row["kind"]), *(str(row[key] or "") for key in columns)) for row in rows]
    return document(
        "Is a model nearest to its own kind?",
        "thesis figure 6.6",
        "Models of animals from part masks against the ground truth of all of them: mean distance both ways.",
        section("Own kind nearest", table(("box", "models"), lines), lead="Bar: every model."),
        section("Distances", gallery(*shown, columns=2)),
        section("Model by model", table(("animal", "kind", *columns), cells)),
    )


def main() -> None:
    """The command line."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("out", type=Path)
    parser.add_argument("--data", type=Path, default=Path("../shared/data"))
    parser.add_argument("--cache", type=Path, default=Path("build/meshes/animal"))
    parser.add_argument("--only", default="", help="names of animals, with commas")
    parser.add_argument("--quick", action="store_true", help="two generated animals")
    given = parser.parse_args()
    given.out.parent.mkdir(parents=True, exist_ok=True)
    if given.quick:
        animals = [meshes.generated(pose) for pose in ("standing", "walking")]
        names, kinds = ["standing", "walking"], ["standing", "walking"]
    else:
        cache = meshes.unpack(given.data, given.cache)
        names = given.only.split(",") if given.only else meshes.names(cache)
        animals = [meshes.load(cache, name) for name in names]
        kinds = [meshes.SPECIES.get(name, name) for name in names]
    params = QUICK if given.quick else Modelling()
    found = []
    for name, animal in zip(names, animals, strict=True):
        found.append(modelled(animal, params, given.out.parent / f"{name}.npz"))
        print(name, flush=True)
    truth = [(animal.vertices, animal.faces) for animal in animals]
    apart = {
        box: distances(*([boxed(mesh, box == BOXES[1]) for mesh in group] for group in (found, truth))) for box in BOXES
    }
    rows = rows_of(apart, names, kinds)
    write_table(given.out, rows, matrices={box: matrix.round(5).tolist() for box, matrix in apart.items()})
    atomic.write_text(given.out, page(apart, rows))
    print(json.dumps([row for row in rows if row[BOXES[0]] != row["kind"]]))


if __name__ == "__main__":
    main()
