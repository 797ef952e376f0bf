"""The files beside an animal's model: the mesh, its page, a page to turn it, and its parts."""

from __future__ import annotations

import hashlib
from collections.abc import Mapping
from functools import partial
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from ipcli.io.files import atomic
from ipcli.io.meshes import assembly
from ipcli.measurements.part_images import PartTree
from ipcli.stages.animal.parameters import ModelAnimal
from ipcli.stages.kit.pages import page, turning_page

if TYPE_CHECKING:
    from ipcli.stages.kit.artefact import Beside

TURNED = 20_000  # faces in the page to turn
LONGEST = 60  # bytes of a part's name within a file name


def side_files(output: Path, params: ModelAnimal, tree: PartTree | None) -> dict[Path, Beside]:
    """Names and writers of all files beside X.h5."""
    suffix = ".glb" if output.suffix == ".h5" else output.suffix
    artefact = output.with_suffix(".h5")
    beside: dict[Path, Beside] = {artefact.with_suffix(suffix): partial(write_mesh, suffix)}
    beside |= page(artefact, "animal-model")
    beside[turning_page(artefact)] = partial(write_turntable, f"model-animal: {artefact.name}")
    if params.separate_parts != "none" and tree is not None:
        for part, name in enumerate(tree.names):
            path = artefact.with_suffix(f".{file_word(name)}.{params.separate_parts}")
            beside[path] = partial(write_part, part, f".{params.separate_parts}")
    return beside


def file_word(name: str) -> str:
    """A part's name as a piece of a file name: as it is when plain and short, else by its digest."""
    plain = "".join(letter if letter.isalnum() or letter in "_-" else "_" for letter in name)
    if plain.isascii() and plain == name and len(plain) <= LONGEST:
        return plain
    return "part-" + hashlib.sha256(name.encode("utf-8")).hexdigest()[:12]


def write_mesh(suffix: str, path: Path, arrays: Mapping[str, np.ndarray], provenance: Mapping[str, Any]) -> None:
    """The whole model with one node a part."""
    comment = f"ipcli model-animal, digest {provenance['digest']}"
    assembly.write(
        path,
        arrays["vertices"],
        arrays["faces"],
        arrays["face_part"],
        [str(name) for name in arrays["parts"]],
        name=str(arrays["name"]),
        extra={"seen_by": arrays["seen_by"]},
        comment=comment,
        suffix=suffix,
    )


def write_part(
    part: int, suffix: str, path: Path, arrays: Mapping[str, np.ndarray], provenance: Mapping[str, Any]
) -> None:
    """One part as a closed body; an empty file for a part that came out empty."""
    stem = f"bodies/{part:03d}"
    vertices = arrays.get(f"{stem}/vertices", np.zeros((0, 3), np.float32))
    faces = arrays.get(f"{stem}/faces", np.zeros((0, 3), np.int32))
    names = [str(name) for name in arrays["parts"]]
    labels = np.full(len(faces), part)
    assembly.write(path, vertices, faces, labels, names, comment=f"digest {provenance['digest']}", suffix=suffix)


def write_turntable(title: str, path: Path, arrays: Mapping[str, np.ndarray], provenance: Mapping[str, Any]) -> None:
    """A page of its own in which the model can be turned, three.js within."""
    atomic.write_text(path, assembly.turnable(
        title, arrays["vertices"], arrays["faces"], arrays["face_part"], [str(name) for name in arrays["parts"]], TURNED
    ))  # fmt: skip
