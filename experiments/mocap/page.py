"""The page and the table of one experiment of chapter 5: `python mocap_page.py NAME OUT.html FILE...`.

NAME is a key of EXPERIMENTS. The files are told apart by their kind: evaluations, named METHOD-SPLIT.evaluation.h5, a
model, and the table of benchmarks/mocap/peers.py (.json). Beside OUT come X.csv and X.json with all right answers in
percent.
"""

import csv
import io
import json
import sys
from pathlib import Path

import numpy as np

from experiments.mocap import experiment as report
from experiments.mocap.experiment import Bar, Experiment, Printed
from ipcli.io.files import atomic, h5

HERE = Path(__file__).parent
LEAD = (
    "aligned: the defaults of mocap-train{mirror}; single poses and unordered frames leave out how the body moves. thesis: "
    "chapter 5 as printed (configs/mocap-train/thesis.toml). known: aligned, of people who are "
    "among those learnt from (--spread 0)."
)
EXPERIMENTS = {
    "hdm05": (
        "Actions of HDM05",
        "288 clips of 11 cut actions by 5 actors (bd, bk, dg, mm, tr), at 30 Hz. Parameters were chosen on bd, bk and "
        "dg. ",
    ),
    "florence": (
        "Florence 3D actions",
        "215 clips of 9 actions by 10 people before a Kinect, 15 joints, positions alone; the 10 published splits, of "
        "which the first three "
        "were used to choose parameters. ",
    ),
    "utkinect": (
        "UTKinect actions",
        "199 clips of 10 actions by 10 people before a Kinect, 20 joints, positions alone; the 10 published splits. ",
    ),
}
QUICK = "A quick look at the generated motions of sample_data: it shows that everything runs, not how good it is. "


def gather(name: str, files: list[Path], quick: bool) -> Experiment:
    """The experiment that these files make up."""
    evaluations, model, peers = {}, None, {}
    for path in files:
        if path.suffix == ".json":
            peers = json.loads(path.read_text(encoding="utf-8"))["tables"]
        elif h5.peek(path).kind == "action-evaluation":
            method, split = path.name.removesuffix(".evaluation.h5").split("-", 1)
            evaluations[method, split] = h5.read(path, "action-evaluation").arrays
        else:
            model = h5.read(path, "behaviours").arrays
    title, lead = EXPERIMENTS[name]
    how = LEAD.format(
        mirror="" if name == "hdm05" else " but for the mirror images of all clips, which are learnt as well (--mirror)"
    )
    lead = QUICK if quick else lead
    printed = {number: read_printed(number) for number in ("5.1", "5.2")} if name == "hdm05" else {}
    return Experiment(title, lead + how, evaluations, model, [] if quick else read_bars(name), printed, peers)


def read_printed(number: str) -> Printed:
    """A table of the thesis."""
    title, head, *lines = (HERE / "thesis" / f"{number}.csv").read_text(encoding="utf-8").splitlines()
    return Printed(title.removeprefix("# "), tuple(head.split(",")), tuple(tuple(row) for row in csv.reader(lines)))


def read_bars(name: str) -> list[Bar]:
    """What the experiment is held to."""
    rows = csv.DictReader(
        line for line in (HERE / "bars.csv").read_text(encoding="utf-8").splitlines() if line[0] != "#"
    )
    return [
        Bar(row["split"], row["query"], row["bar"], float(row["goal"]) if row["goal"] else None, row["why"])
        for row in rows
        if row["experiment"] == name
    ]


def rows_of(e: Experiment) -> list[dict[str, object]]:
    """A row for each method, split and query."""
    rows = []
    for method, split in e.evaluations:
        for query in e.queries:
            shares = e.shares(method, split, query)
            known = 100 * shares[np.isfinite(shares)]
            spread = round(float(known.std(ddof=1)), 3) if len(known) > 1 else None
            rows.append(
                {
                    "method": method,
                    "split": split,
                    "query": query,
                    "right %": round(float(known.mean()), 3),
                    "sd": spread,
                    "splits": len(known),
                }
            )
    return rows


def write_table(out: Path, e: Experiment) -> None:
    """All figures as CSV and JSON."""
    rows, text = rows_of(e), io.StringIO()
    writer = csv.DictWriter(text, list(rows[0]), lineterminator="\n")
    writer.writeheader()
    writer.writerows(rows)
    atomic.write_text(out.with_suffix(".csv"), text.getvalue())
    atomic.write_text(out.with_suffix(".json"), json.dumps({"title": e.title, "rows": rows}, indent=1) + "\n")


if __name__ == "__main__":
    quick, (name, out, *files) = "--quick" in sys.argv, [argument for argument in sys.argv[1:] if argument != "--quick"]
    experiment = gather(name, [Path(file) for file in files], quick)
    write_table(Path(out), experiment)
    atomic.write_text(Path(out), report.page(experiment))
