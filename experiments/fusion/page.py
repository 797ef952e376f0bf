"""The page, the figures and the table of one experiment of chapter 4: `python fusion_page.py NAME OUT.html FILE...`.

NAME is a key of EXPERIMENTS. The files are told apart by their kind: the comparison over the scenes, the tuning, the
trials of each scene (beside OUT) or of each setting of a sweep (in a folder SWEEP-VALUE), and the panels of
scale_space.py (.npz). Beside OUT come X.csv and X.json with the means over the scenes, and figures/ as PDF and PNG.
"""

import csv
import io
import json
import sys
from collections import defaultdict
from pathlib import Path

from experiments.fusion import experiment as report
from experiments.fusion.experiment import Bar, Experiment, Printed
from experiments.kit import figures
from ipcli.io.files import atomic, h5, npz
from ipcli.models.fusion.parameters import Fusion, parse_variants

HERE = Path(__file__).parent
SYNTHETIC = (
    "Thesis: the authors' printed averages over their own renderings. Ours: the same camera, noise and path on the "
    "meshes named below, observations "
    "looked up anew by the first fused map. Measures as the authors' code computes them: RMSE after the mean error is "
    "taken out (centred RMSE), "
    "Z-MAE after the median error, normals that are missing count 90°, disparities after KITTI's background "
    "interpolation."
)
EXPERIMENTS = {
    "objects": {
        "title": "Fusion of rendered objects",
        "lead": "Eleven depth maps of an orbit of radius 3 about an object of radius 1, with Laplace noise of scale "
        "0.6 (thesis table 4.2, "
        "figures 4.1 to 4.4, 4.8, 4.9).",
        "conventions": SYNTHETIC,
    },
    "urban": {
        "title": "Fusion of rendered city blocks",
        "lead": "Eleven depth maps looking down from 300 m, 4 m apart, with Laplace noise of scale 6 (thesis table "
        "4.3, figures 4.5, 4.6, 4.10).",
        "conventions": SYNTHETIC
        + " The authors' four models (Hagia Sophia and others) are not to be had; ours are open city models of Delft.",
    },
    "kitti": {
        "title": "Fusion of KITTI stereo disparities",
        "lead": "Disparities of both cameras in two frames, or in up to five, fused into the left camera of frame 10 "
        "(thesis tables 4.4, 4.5).",
        "conventions": "Thesis: 194 training scenes with the disparities of the matcher named, up to five frames, and "
        "errors on pixels that are not "
        "occluded. Ours: the scenes named below, OpenCV's semi-global matching of both cameras, the authors' poses. "
        "Every map is completed by "
        "KITTI's background interpolation, so that all are judged on the same pixels. Compare the gains, not the "
        "levels.",
        "arithmetic": True,
    },
    "livingroom": {
        "title": "Fusion of a living room",
        "lead": "Eleven depth maps of an ICL-NUIM recording with Laplace noise of 30 mm. The thesis has no such "
        "experiment.",
        "conventions": "",
    },
}


def gather(name: str, out: Path, files: list[Path], quick: bool) -> Experiment:
    """The experiment that these files make up."""
    found = {"scenes": {}, "sweeps": defaultdict(lambda: defaultdict(list)), "panels": {}}
    for path in files:
        kind = "panels" if path.suffix == ".npz" else h5.peek(path).kind
        if kind == "panels":
            found["panels"] = npz.read(path)
        elif kind == "fusion-trials" and path.parent != out.parent:
            sweep, _, value = path.parent.name.rpartition("-")
            found["sweeps"][sweep][float(value)].append(
                h5.read(path, "fusion-trials", only=lambda n: n in ("methods", "rules", "columns", "values")).arrays
            )
        elif kind == "fusion-trials":
            found["scenes"][path.name.split(".")[0]] = h5.read(path, "fusion-trials").arrays
        else:
            found["table" if kind == "fusion-comparison" else kind.removeprefix("fusion-")] = h5.read(path, kind).arrays
    about = dict(EXPERIMENTS[name])
    if quick:
        about["lead"] = (
            "A quick look at small generated scenes: it shows that everything runs, not how good it is. "
            + about["lead"]
        )
    bars = [] if quick else read_bars(name)
    return Experiment(
        default=parse_variants(Fusion.method)[0].label, printed=read_printed(name), bars=bars, **about, **found
    )


def read_printed(name: str) -> list[Printed]:
    """The tables of the thesis that belong to an experiment."""
    return [_printed(path) for path in sorted((HERE / "thesis").glob(f"{name}*.csv"))]


def _printed(path: Path) -> Printed:
    title, head, *lines = path.read_text(encoding="utf-8").splitlines()
    columns = tuple(head.split(",")[2:])
    rows = tuple((name, ours, tuple(map(float, values))) for name, ours, *values in csv.reader(lines))
    return Printed(title.removeprefix("# "), columns, rows)


def read_bars(name: str) -> list[Bar]:
    """What the experiment is held to."""
    rows = csv.DictReader(
        line for line in (HERE / "bars.csv").read_text(encoding="utf-8").splitlines() if line[0] != "#"
    )
    return [
        Bar(row["measure"], float(row["bar"]), float(row["goal"]) if row["goal"] else None, row["why"])
        for row in rows
        if row["experiment"] == name
    ]


def write_table(out: Path, e: Experiment) -> None:
    """Means over the scenes of every row, as CSV and JSON."""
    methods = [str(name) for name in e.table["methods"]]
    rows = [{"method": method} | {column: e.mean(method, column) for column in e.columns} for method in methods]
    text = io.StringIO()
    writer = csv.DictWriter(text, ["method", *e.columns], lineterminator="\n")
    writer.writeheader()
    writer.writerows(rows)
    atomic.write_text(out.with_suffix(".csv"), text.getvalue())
    known = [{key: None if value != value else value for key, value in row.items()} for row in rows]
    about = {"scenes": [str(name) for name in e.table["scenes"]], "default": e.default, "rows": known}
    atomic.write_text(out.with_suffix(".json"), json.dumps(about, indent=1, ensure_ascii=False) + "\n")


def write_figures(folder: Path, e: Experiment) -> None:
    """What the page shows, as files."""
    for measure, name in (("Z-avg", "depth-error"), ("D-avg px", "disparity-error")):
        if e.sweeps:
            figures.charts(folder, name, report.sweep_charts(e, measure))
    if chart := report.confidence_chart(e):
        figures.charts(folder, "sparsification", [chart])
    if e.scenes:
        figures.pictures(folder, "surfaces", [report.surfaces(trials) for trials in e.scenes.values()])
    for number, panels in report.scale_space(e.panels).items():
        half = -(-len(panels) // 2)
        figures.pictures(folder, f"scale-space-{number}", [panels[:half], panels[half:]])


if __name__ == "__main__":
    quick, (name, out, *files) = "--quick" in sys.argv, [argument for argument in sys.argv[1:] if argument != "--quick"]
    experiment = gather(name, Path(out), [Path(file) for file in files], quick)
    write_table(Path(out), experiment)
    write_figures(Path(out).parent / "figures", experiment)
    atomic.write_text(Path(out), report.page(experiment))
