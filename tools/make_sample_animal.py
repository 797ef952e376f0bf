"""Make sample_data/animal: part masks of an invented animal of round limbs, in two poses, and their projects.

    python tools/make_sample_animal.py [FOLDER]

Everything is computed, so the same pixels come out on every machine.
"""

from __future__ import annotations

import argparse
from pathlib import Path

import numpy as np

from ipcli.geometry.orthographic import NAMED, looking, of_view
from ipcli.geometry.part_masks import framed, render
from ipcli.io.files.atomic import write_text
from ipcli.io.files.images import write_png
from ipcli.models.animal.limbs import POSES, four_legged

VIEWS = ("left", "right", "front", "back", "top", "beside")
BESIDE = (40.0, 15.0)  # azimuth and elevation of the view without a name
LONGEST = 200  # pixels


def make(folder: Path) -> None:
    """Write the masks and a project for each pose."""
    for pose in POSES:
        vertices, faces, labels, tree = four_legged(pose)
        lines = [f'name = "{pose}"', "", "[parts]"]
        parents = [tree.names[parent] if parent >= 0 else "" for parent in tree.parents]
        lines += [f'{name} = "{parent}"' for name, parent in zip(tree.names, parents, strict=True)]
        for view in VIEWS:
            rotation = of_view(view) if view in NAMED else looking(*BESIDE)
            camera, shape = framed(vertices, rotation, LONGEST)
            seen, _ = render(vertices, faces, labels, camera, shape)
            write_png(folder / pose / f"{view}.png", seen.astype(np.uint8))
            lines += ["", "[[images]]", f'masks = "{pose}/{view}.png"']
            lines += [f'view = "{view}"'] if view in NAMED else ["# no view: its camera is found"]
        write_text(folder / f"{pose}.toml", "\n".join(lines) + "\n")


if __name__ == "__main__":
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("folder", type=Path, nargs="?", default=Path("sample_data/animal"))
    make(parser.parse_args().folder)
