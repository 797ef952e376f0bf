"""Attack all readers of ipcli with damaged files and with artefacts that contradict themselves:

    python -m tools.attack [--files 20000] [--only views/tum] [--seed 0]

Each file is read in a child process with limits on time and memory; what came of it is counted. Exit 1 when anything
but a sound reading or an error of ipcli came of one. The same seed gives the same files.
"""

from __future__ import annotations

import argparse

from tests.fixtures.attack.run import FAULTS, attack, table
from tests.fixtures.attack.seeds import SEEDS


def main() -> int:
    """Run the attack and print its report."""
    parser = argparse.ArgumentParser(description="Attack all readers with damaged files.")
    parser.add_argument("--files", type=int, default=20_000, help="damaged files in all")
    parser.add_argument("--only", default="", help="seeds whose names start so")
    parser.add_argument("--seed", type=int, default=0)
    given = parser.parse_args()
    weights = {name: seed.weight for name, seed in SEEDS.items() if name.startswith(given.only)}
    if not weights:
        parser.error(f"no seed starts with '{given.only}'. Known: {', '.join(SEEDS)}")
    scale = given.files / sum(weights.values())
    entries = attack({name: max(round(scale * weight), 1) for name, weight in weights.items()}, given.seed)
    print("\n".join(table(entries)))
    return int(any(entry["outcome"] in FAULTS for entry in entries))


if __name__ == "__main__":
    raise SystemExit(main())
