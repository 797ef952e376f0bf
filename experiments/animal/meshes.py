"""Ground-truth animals with named parts: the Princeton four-legged set and TOSCA, in the axes of ipcli (x forward, y to
the left, z up), and generated ones for a quick look.
"""

from __future__ import annotations

import json
import tarfile
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from ipcli.measurements.part_images import PartTree

PARENTS = {
    "torso": "",
    "neck": "torso",
    "head": "neck",
    "tail": "torso",
    **{f"{end}_leg_{side}": "torso" for end in ("front", "back") for side in "LR"},
}
TOSCA_PARTS = ("head", "neck", "torso", "tail", "front_leg_L", "front_leg_R", "back_leg_L", "back_leg_R")
TOSCA_CLASSES = ("horse", "cat", "dog")
# methods were developed on these; all others are only reported
DEVELOPMENT = ("387", "390", "400", "cat0", "horse0")
SPECIES = {
    "381": "cow", "384": "fox", "387": "horse", "388": "pig", "389": "big cat", "390": "giraffe", "391": "bull",
    "392": "pig", "393": "camel", "394": "dog", "395": "horse", "396": "horse", "397": "horse", "398": "lion",
    "399": "fawn", "400": "calf", "383": "rhino", "386": "goat", "382": "hoofed",
    "horse0": "horse", "horse10": "horse", "horse15": "horse", "cat0": "cat", "cat5": "cat", "dog0": "dog",
    "dog5": "dog",
}  # fmt: skip


@dataclass(frozen=True, eq=False)
class Animal:
    """A labelled mesh: vertices (n, 3), faces (m, 3), the part of each face (m,) counted from 1, and the tree."""

    name: str
    vertices: np.ndarray
    faces: np.ndarray
    labels: np.ndarray
    tree: PartTree

    @property
    def diagonal(self) -> float:
        """Of the bounding box."""
        return float(np.linalg.norm(np.ptp(self.vertices, axis=0)))


def unpack(data: Path, cache: Path) -> Path:
    """The two sets below `cache`, extracted from `data`/animal if they are not there yet."""
    for name in ("psb_fourleg", "tosca"):
        if not (cache / name / ".whole").is_file():
            with tarfile.open(data / "animal" / name / f"{name}.tar.xz") as archive:
                archive.extractall(cache, filter="data")
            (cache / name / ".whole").touch()
    return cache


def names(cache: Path) -> list[str]:
    """All animals with named parts."""
    known = json.loads((cache / "psb_fourleg" / "part_names.json").read_text())
    poses = [path.stem for path in (cache / "tosca").glob("*.off") if path.stem.rstrip("0123456789") in TOSCA_CLASSES]
    return sorted(key for key in known if key.isdigit()) + sorted(poses)


def load(cache: Path, name: str) -> Animal:
    """The animal of that name."""
    return princeton(cache / "psb_fourleg", name) if name.isdigit() else tosca(cache / "tosca", name)


def princeton(folder: Path, name: str) -> Animal:
    """One of the Princeton four-legged set, with the human segmentation that part_names.json names."""
    about = json.loads((folder / "part_names.json").read_text())[name]
    vertices, faces = _off(folder / "off" / f"{name}.off")
    segments = np.loadtxt(folder / "seg" / name / about["seg"], dtype=int)
    parts = [about["names"][str(segment)] for segment in segments]
    return _animal(name, vertices @ axes(about["up"], about["forward"]).T, faces, parts)


def tosca(folder: Path, name: str) -> Animal:
    """A pose of TOSCA (up z, forward -y) with the parts cut by planes."""
    vertices, faces = _off(folder / f"{name}.off")
    labels = np.loadtxt(folder / f"{name.rstrip('0123456789')}_faces_parts_planecut.txt", dtype=int)
    return _animal(name, vertices @ axes("z", "-y").T, faces, [TOSCA_PARTS[label] for label in labels])


def rigged(name: str, vertices: np.ndarray, faces: np.ndarray, parts: list[str]) -> Animal:
    """A posed rig (up y, forward z)."""
    return _animal(name, vertices @ axes("y", "z").T, faces, parts)


def axes(up: str, forward: str) -> np.ndarray:
    """Rotation (3, 3) to x forward, y left, z up from axes such as "y" and "-x"."""
    x, z = (_axis(word) for word in (forward, up))
    return np.stack([x, np.cross(z, x), z])


def _axis(word: str) -> np.ndarray:
    return np.eye(3)["xyz".index(word[-1])] * (-1 if word.startswith("-") else 1)


def _off(path: Path) -> tuple[np.ndarray, np.ndarray]:
    words = path.read_text().split()
    count, faces = int(words[1]), int(words[2])
    vertices = np.array(words[4 : 4 + 3 * count], np.float64).reshape(-1, 3)
    return vertices, np.array(words[4 + 3 * count :][: 4 * faces], np.int64).reshape(-1, 4)[:, 1:]


def _animal(name: str, vertices: np.ndarray, faces: np.ndarray, parts: list[str]) -> Animal:
    present = [part for part in PARENTS if part in parts]
    tree = PartTree(tuple(present), tuple(_parent(part, present) for part in present))
    labels = np.array([present.index(part) + 1 for part in parts], np.int16)
    vertices = vertices - (vertices.min(axis=0) + vertices.max(axis=0)) / 2
    return Animal(name, vertices / np.linalg.norm(np.ptp(vertices, axis=0)), faces, labels, tree)


def _parent(part: str, present: list[str]) -> int:
    parent = PARENTS[part]
    while parent and parent not in present:
        parent = PARENTS[parent]
    return present.index(parent) if parent else -1


def two_poses() -> tuple[Animal, Animal]:
    """The generated animal, walking and standing."""
    return generated("walking"), generated()


def generated(pose: str = "standing") -> Animal:
    """A small four-legged animal of round limbs, for a quick look."""
    from ipcli.models.animal.limbs import four_legged

    vertices, faces, labels, tree = four_legged(pose)
    vertices = vertices - (vertices.min(axis=0) + vertices.max(axis=0)) / 2
    return Animal("generated", vertices / np.linalg.norm(np.ptp(vertices, axis=0)), faces, labels, tree)
