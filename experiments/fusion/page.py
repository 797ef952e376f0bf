"""The page, the figures and the table of one experiment of chapter 4: `python -m experiments.fusion.page NAME OUT.html
FILE...`.

NAME is a key of EXPERIMENTS. The files are told apart by their kind: the comparison over the scenes, the tuning, the
trials of each scene (beside OUT) or of each setting of a sweep (in a folder SWEEP-VALUE), and the panels of
scale_space.py (.npz). Beside OUT come X.csv and X.json with the means over the scenes, and figures/ as PDF and PNG.
"""

from collections import defaultdict
from pathlib import Path
from typing import Any

from experiments.fusion import choices
from experiments.fusion import experiment as report
from experiments.fusion.experiment import FusionExperiment
from experiments.kit import figures
from experiments.kit.arguments import Arguments
from experiments.kit.bars import read_bars
from experiments.kit.credits import read_credits
from experiments.kit.printed import Printed, read_printed
from experiments.kit.run import Findings, quick_lead, run
from ipcli.io.files import h5, npz
from ipcli.models.fusion.parameters import Fusion, parse_variants

HERE = Path(__file__).parent
SWEPT = ("methods", "rules", "columns", "values")  # what is needed of the trials of a sweep
SYNTHETIC = (
    "Thesis: the authors' printed averages over their own renderings. Ours: the same camera, noise and path on the "
    "meshes named below, observations "
    "looked up anew by the first fused map. Measures as the authors' code computes them: RMSE after the mean error is "
    "taken out (centred RMSE), "
    "Z-MAE after the median error, normals that are missing count 90°, disparities after KITTI's background "
    "interpolation."
)
EXPERIMENTS: dict[str, dict[str, Any]] = {
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


def gather(arguments: Arguments) -> FusionExperiment:
    """The experiment that these files make up."""
    name, quick = arguments.name, arguments.quick
    found: dict[str, Any] = {"scenes": {}, "sweeps": defaultdict(lambda: defaultdict(list)), "panels": {}}
    for path in arguments.files:
        kind = "panels" if path.suffix == ".npz" else h5.peek(path).kind
        if kind == "panels":
            found["panels"] = npz.read(path)
        elif kind == "fusion-trials" and path.parent != arguments.out.parent:
            sweep, _, value = path.parent.name.rpartition("-")
            found["sweeps"][sweep][float(value)].append(h5.read(path, kind, only=SWEPT.__contains__).arrays)
        elif kind == "fusion-trials":
            found["scenes"][path.name.split(".")[0]] = h5.read(path, kind).arrays
        else:
            found["table" if kind == "fusion-comparison" else kind.removeprefix("fusion-")] = h5.read(path, kind).arrays
    about = dict(EXPERIMENTS[name])
    if quick:
        about["lead"] = quick_lead("small generated scenes") + about["lead"]
    else:
        about |= {"bars": read_bars(HERE / "bars.csv", name), "credits": read_credits(HERE / "data.csv", name)}
    return FusionExperiment(
        default=parse_variants(Fusion.method)[0].label, printed=printed_tables(name), **about, **found
    )


def printed_tables(name: str) -> list[Printed]:
    """The tables of the thesis that belong to an experiment: name, the row of ours to hold it against, figures."""
    return [read_printed(path) for path in sorted((HERE / "thesis").glob(f"{name}*.csv"))]


def rows_of(e: FusionExperiment) -> list[dict[str, object]]:
    """A row for each method, at the automatic lambda and at the tuned one: means over the scenes."""
    methods = [str(name) for name in e.table["methods"]]
    return [{"method": method} | {column: e.mean(method, column) for column in e.columns} for method in methods]


def write_figures(folder: Path, e: FusionExperiment) -> None:
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


def make(arguments: Arguments) -> Findings:
    """The page, the table and the figures of one experiment."""
    if arguments.name in choices.CHOICES:
        return choices.make(arguments)
    e = gather(arguments)
    about = {"scenes": [str(name) for name in e.table["scenes"]], "default": e.default}
    return Findings(report.page(e), rows_of(e), about, lambda folder: write_figures(folder, e))


if __name__ == "__main__":
    run([*EXPERIMENTS, *choices.CHOICES], make)
