"""Streams depend on seed, stage and name, and on nothing else."""

import subprocess
import sys

import numpy as np

from ipcli.rng import stream


def test_a_change_of_any_part_of_the_name_gives_an_independent_stream():
    names = [(0, "a", "b"), (1, "a", "b"), (0, "b", "a"), (0, "ab", ""), (0, "", "ab"), (0, "a", "c")]
    draws = np.array([stream(*name).standard_normal(20_000) for name in names])
    off_diagonal = np.corrcoef(draws)[~np.eye(len(names), dtype=bool)]
    assert np.abs(off_diagonal).max() < 5 / np.sqrt(20_000)  # five standard errors of an independent pair


def test_the_numbers_are_the_same_in_another_process_whatever_its_hash_seed():
    code = "from ipcli.rng import stream; print(stream(3, 'fuse', 'é').integers(0, 1 << 60, 4).tolist())"
    outputs = [
        subprocess.run(
            [sys.executable, "-c", code],
            env={"PYTHONHASHSEED": seed, "PYTHONPATH": ":".join(sys.path)},
            capture_output=True,
            text=True,
            check=True,
        ).stdout
        for seed in ("0", "1")
    ]
    assert outputs == [f"{stream(3, 'fuse', 'é').integers(0, 1 << 60, 4).tolist()}\n"] * 2
