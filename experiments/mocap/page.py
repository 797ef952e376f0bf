"""The page and the table of one experiment of chapter 5: `python -m experiments.mocap.page NAME OUT.html FILE...`.

NAME is a key of EXPERIMENTS, or takes. The files are told apart by their kind: evaluations, named
METHOD-SPLIT.evaluation.h5, a model, and the table of benchmarks/mocap/peers.py (.json); takes_page.py has those of
takes. Beside OUT come X.csv and X.json with all right answers in percent.
"""

import json
from pathlib import Path

import numpy as np

from experiments.kit.arguments import Arguments
from experiments.kit.bars import read_bars
from experiments.kit.credits import read_credits
from experiments.kit.printed import Printed, read_printed
from experiments.kit.run import Findings, quick_lead, run
from experiments.mocap import experiment as report
from experiments.mocap import takes_page
from experiments.mocap.experiment import RecognitionExperiment
from ipcli.io.files import h5

HERE = Path(__file__).parent
LEAD = (
    "aligned: the defaults of mocap-train{mirror}; single poses and unordered frames leave out how the body moves. "
    "thesis: "
    "chapter 5 as printed (--config mocap-train/thesis). known: aligned, of people who are "
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
GENERATED = "the generated motions of sample_data"


def gather(arguments: Arguments) -> RecognitionExperiment:
    """The experiment that these files make up."""
    name, quick = arguments.name, arguments.quick
    evaluations, model, peers = {}, None, {}
    for path in arguments.files:
        if path.suffix == ".json":
            peers = json.loads(path.read_text(encoding="utf-8"))["tables"]
        elif (kind := h5.peek(path).kind) == "action-evaluation":
            method, split = path.name.removesuffix(".evaluation.h5").split("-", 1)
            evaluations[method, split] = h5.read(path, kind).arrays
        else:
            model = h5.read(path, "behaviours").arrays
    title, lead = EXPERIMENTS[name]
    how = LEAD.format(
        mirror="" if name == "hdm05" else " but for the mirror images of all clips, which are learnt as well (--mirror)"
    )
    lead = quick_lead(GENERATED) if quick else lead
    bars = [] if quick else read_bars(HERE / "bars.csv", name)
    credits = [] if quick else read_credits(HERE / "data.csv", name)
    printed = {number: printed_table(number) for number in ("5.1", "5.2")} if name == "hdm05" else {}
    return RecognitionExperiment(title, lead + how, evaluations, model, bars, printed, peers, credits)


def printed_table(number: str) -> Printed:
    """A table of the thesis."""
    return read_printed(HERE / "thesis" / f"{number}.csv")


def rows_of(e: RecognitionExperiment) -> list[dict[str, object]]:
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


def make(arguments: Arguments) -> Findings:
    """The page and the table of one experiment."""
    if arguments.name == takes_page.NAME:
        lead = quick_lead(GENERATED) if arguments.quick else ""
        credits = [] if arguments.quick else read_credits(HERE / "data.csv", takes_page.NAME)
        return takes_page.make(arguments.files, lead, credits)
    e = gather(arguments)
    return Findings(report.page(e), rows_of(e), {"title": e.title})


if __name__ == "__main__":
    run([*EXPERIMENTS, takes_page.NAME], make)
