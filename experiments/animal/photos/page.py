"""Photographs of PASCAL-Part, each modelled from one view: `python -m experiments.animal.photos.page OUT.html`.

One photograph tells nothing of depth, so each part is as thick as its outline is wide; what matters here is that masks
of real pictures, with parts missing and hidden, become closed bodies with the right parts. Each model and its own page
lie beside OUT.
"""

from __future__ import annotations

import argparse
import json
import time
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np

from ipcli.io.files import atomic, h5
from ipcli.models.animal.parameters import Inflation, Modelling, Volume
from ipcli.params import Run
from ipcli.report.animal import surfaces
from ipcli.report.kit.page import element, figure, gallery, section, table
from ipcli.report.kit.page import page as document
from ipcli.report.kit.pictures import photograph
from ipcli.stages.animal import check_mesh, model_animal
from ipcli.stages.animal.parameters import ModelAnimal

FOLDER = Path("animal") / "pascal_part"
QUICK = Modelling(inflation=Inflation(triangles=300), volume=Volume(voxels=48))
AROUND, LONGEST = 4, 300  # pictures of a model, and pixels of their longer side
LEGS = {
    f"{side}{end[0]}{part}": f"{end}_leg_{side.upper()}"
    for side in "lr"
    for end in ("front", "back")
    for part in ("leg", "pa")
}
HEAD = dict.fromkeys(("lear", "rear", "leye", "reye", "muzzle", "nose", "beak"), "head")


@dataclass(frozen=True)
class Subject:
    """An object of a photograph: its parts and their parents, the side that is seen, what names are translated."""

    photo: str
    number: int
    view: str
    parts: dict[str, str]
    rename: dict[str, str]


FOUR = {"torso": "", "head": "torso", "tail": "torso"} | dict.fromkeys(dict.fromkeys(LEGS.values()), "torso")
BIRD = {"torso": "", "neck": "torso", "head": "neck", "leg_L": "torso", "leg_R": "torso"}
FEATHERED = HEAD | {"lleg": "leg_L", "lfoot": "leg_L", "rleg": "leg_R", "rest": "torso"}
SUBJECTS = {
    "dog": Subject("2008_005643", 0, "front", FOUR, HEAD | LEGS | {"neck": "torso", "rest": "torso"}),
    "cat": Subject("2010_005275", 0, "front", FOUR, HEAD | LEGS | {"neck": "torso", "rest": "torso"}),
    "flamingo": Subject("2010_005511", 1, "right", BIRD, FEATHERED),
    "half hidden flamingo": Subject("2010_005511", 0, "right", BIRD, FEATHERED),
}


def project(name: str, subject: Subject, folder: Path) -> str:
    """The TOML of a subject whose photograph and masks lie in a folder; parts that its masks lack are left out."""
    from ipcli.io.parts import pascal

    masks = (folder / f"{subject.photo}.mat").resolve()
    names, labels = pascal.read(masks, subject.number)
    shown = {subject.rename.get(names[k], names[k]) for k in range(len(names)) if (labels == k + 1).any()}
    present = [part for part in subject.parts if part in shown]
    rename = ", ".join(f'{old} = "{new}"' for old, new in subject.rename.items() if old in names)
    lines = [f'name = "{name}"', "", "[parts]", *(f'{part} = "{_parent(part, subject, present)}"' for part in present)]
    lines += ["", "[[images]]", f"masks = {json.dumps(str(masks))}", f"object = {subject.number}"]
    lines += [f'view = "{subject.view}"', f"rename = {{ {rename} }}"]
    lines += [f"picture = {json.dumps(str(masks.with_suffix('.jpg')))}"]
    return "\n".join(lines) + "\n"


def _parent(part: str, subject: Subject, present: list[str]) -> str:
    """The nearest part above that is there."""
    above = subject.parts[part]
    while above and above not in present:
        above = subject.parts[above]
    return above


def made(source: Path, output: Path, params: Modelling) -> dict[str, Any]:
    """The model of a project, and what is told of it."""
    started = time.perf_counter()
    model_animal.run(source, output, ModelAnimal(modelling=params), Run(overwrite=True))
    seconds = time.perf_counter() - started
    arrays = h5.read(output.with_suffix(".h5"), "animal-model").arrays
    colours = surfaces.colours_of(arrays["face_part"])
    shots = surfaces.turntable(arrays["vertices"].astype(np.float64), arrays["faces"], colours, AROUND, LONGEST)
    stem = "pictures/000"
    drawn = surfaces.overlay(arrays[f"{stem}/labels"], arrays[f"{stem}/rendered"], arrays.get(f"{stem}/picture"))
    return {
        "parts": len(np.unique(arrays["face_part"])),
        "overlap": float(arrays["overlaps"][0]),
        "watertight": bool(check_mesh.check(output)["watertight"]),
        "seconds": seconds,
        "pictures": [drawn, *shots],
    }


def page(results: dict[str, dict[str, Any]]) -> str:
    """Over its photograph and from around, one subject after the other."""
    rows = [
        (
            element("a", name, href=f"{name.replace(' ', '-')}.html"),
            one["parts"],
            f"{100 * one['overlap']:.0f} %",
            "yes" if one["watertight"] else "no",
            f"{one['seconds']:.1f}",
        )
        for name, one in results.items()
    ]
    shown = [
        section(
            name, gallery(*(figure(photograph(picture, 420), "") for picture in one["pictures"]), columns=1 + AROUND)
        )
        for name, one in results.items()
    ]
    head = ("subject", "parts", "right part in the picture", "closed", "seconds")
    return document("Animals from one photograph", "experiments/animal", __doc__.split("\n\n")[1].replace("\n", " "),
                    section("Models", table(head, rows)), *shown)  # fmt: skip


def main() -> None:
    """The command line."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("out", type=Path)
    parser.add_argument("--data", type=Path, default=Path("../shared/data"))
    parser.add_argument("--quick", action="store_true", help="one view of the sample's animal in place of photographs")
    given = parser.parse_args()
    folder = given.out.parent
    folder.mkdir(parents=True, exist_ok=True)
    if given.quick:
        sample = Path("sample_data/animal/standing.toml").read_text().split("[[images]]")
        masks = sample[1].replace('masks = "', f'masks = "{Path("sample_data/animal").resolve()}/')
        texts = {"sample": "[[images]]".join([sample[0], masks])}
    else:
        texts = {name: project(name, subject, given.data / FOLDER) for name, subject in SUBJECTS.items()}
    results = {}
    for name, text in texts.items():
        source = folder / f"{name.replace(' ', '-')}.toml"
        atomic.write_text(source, text)
        results[name] = made(source, source.with_suffix(".glb"), QUICK if given.quick else Modelling())
        told = {key: value for key, value in results[name].items() if key != "pictures"}
        print(name, told, flush=True)
    table_of = [{"subject": name} | {k: v for k, v in one.items() if k != "pictures"} for name, one in results.items()]
    atomic.write_text(given.out.with_suffix(".json"), json.dumps(table_of, indent=1) + "\n")
    atomic.write_text(given.out, page(results))


if __name__ == "__main__":
    main()
