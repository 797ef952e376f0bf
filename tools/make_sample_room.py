"""Make sample_data/room: somebody looks for red parcels in a generated room, seen by a head-mounted stereo rig.

    python tools/make_sample_room.py [FOLDER]

An EuRoC folder (pictures, cam0_sensor.yaml, cam1_sensor.yaml, gt_cam0.tum) with gaze.csv. Without targets.csv: gaze is
on the middles of the parcels, and what is seen is their surfaces, so that points of regard lie elsewhere. Everything
follows from the seed. Attention turns often, so that six seconds hold subsequences enough for `saliency` to learn from.
"""

from __future__ import annotations

import argparse
from pathlib import Path

from experiments.gaze.room import Course, walk, write_euroc
from experiments.saliency.search_tasks import task

SEED = 3
COURSE = Course(frames=60, width=360, height=270, rate=10.0, noise=1.0, picture_noise=1.0, dwell=(0.6, 0.9))
QUALITY = 72


def main(folder: Path) -> None:
    """Write the sample."""
    write_euroc(walk(COURSE, SEED, task("red", SEED)), folder, jpeg=QUALITY)
    (folder / "targets.csv").unlink()


if __name__ == "__main__":
    parser = argparse.ArgumentParser(description=(__doc__ or "").splitlines()[0])
    parser.add_argument("folder", nargs="?", type=Path, default=Path("sample_data/room"))
    main(parser.parse_args().folder)
