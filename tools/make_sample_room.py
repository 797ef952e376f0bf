"""Make sample_data/room: a generated room seen by a head-mounted stereo rig, with the head's path and gaze on targets.

    python tools/make_sample_room.py [FOLDER]

An EuRoC folder (pictures, cam0_sensor.yaml, cam1_sensor.yaml, gt_cam0.tum) with gaze.csv and targets.csv. Everything
follows from the seed.
"""

from __future__ import annotations

import argparse
from pathlib import Path

from experiments.gaze.room import Course, walk, write_euroc

SEED = 3
COURSE = Course(frames=44, width=400, height=300, rate=12.0, noise=1.0, picture_noise=1.0)
QUALITY = 76


def main(folder: Path) -> None:
    """Write the sample."""
    write_euroc(walk(COURSE, SEED), folder, jpeg=QUALITY)


if __name__ == "__main__":
    parser = argparse.ArgumentParser(description=(__doc__ or "").splitlines()[0])
    parser.add_argument("folder", nargs="?", type=Path, default=Path("sample_data/room"))
    main(parser.parse_args().folder)
