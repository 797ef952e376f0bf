"""The page of an experiment of chapter 4: our figures beside those that the thesis prints, curves, surfaces, and the
bars.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, field

import numpy as np

from experiments.kit.bars import Bar, Standing, bars_section
from experiments.kit.charts import Chart, Panel
from experiments.kit.credits import Credit, credits_section
from experiments.kit.printed import Printed
from experiments.kit.run import page_of
from ipcli.measurements.accuracy import depth_average, mean_over_scenes
from ipcli.report.fusion import fusion_tuning
from ipcli.report.fusion.accuracy import best
from ipcli.report.fusion.fusion_trials import SHOWN, SPARSIFICATION, extent, lights
from ipcli.report.kit.curves import Series
from ipcli.report.kit.numbers import aligned, number
from ipcli.report.kit.page import Markup, details, element, gallery, section, table
from ipcli.report.kit.pictures import robust
from ipcli.report.kit.surface import SHADE

TUNED = ", tuned λ"
SWEEPS = {  # folder names and what they vary
    "laplace": "scale of the Laplace noise, m.u.",
    "gauss": "standard deviation of the normal noise, m.u.",
    "views": "number of depth maps",
    "spacing": "spacing of the views, steps of 5° (orbit) or m.u. (flight)",
}
Arrays = Mapping[str, np.ndarray]


@dataclass(frozen=True, eq=False)
class FusionExperiment:
    """All that a page shows. `default` is the row that a user gets who chooses nothing."""

    title: str
    lead: str
    conventions: str
    default: str
    table: Arrays
    tuning: Arrays | None = None
    scenes: Mapping[str, Arrays] = field(default_factory=dict)
    sweeps: Mapping[str, Mapping[float, Sequence[Arrays]]] = field(default_factory=dict)
    printed: Sequence[Printed] = ()
    bars: Sequence[Bar] = ()
    panels: Arrays = field(default_factory=dict)
    arithmetic: bool = False
    credits: Sequence[Credit] = ()

    @property
    def methods(self) -> list[str]:
        """Rows at the automatic lambda, and those without one."""
        return [str(name) for name in self.table["methods"] if not str(name).endswith(TUNED)]

    @property
    def columns(self) -> list[str]:
        """Measures, with the thesis' average of the depth errors."""
        return [*map(str, self.table["columns"]), "Z-avg"]

    @property
    def measure(self) -> str:
        """The measure that lambda was tuned for."""
        return str(self.tuning["measure"]) if self.tuning is not None else "RMSE"

    def mean(self, method: str, measure: str) -> float:
        """Mean of a measure over the scenes; NaN for a method that was not run."""
        names = list(map(str, self.table["methods"]))
        if method not in names or measure not in self.columns:
            return float("nan")
        return float(self._means[names.index(method), self.columns.index(measure)])

    @property
    def _means(self) -> np.ndarray:
        return averaged(self.table["values"], list(map(str, self.table["columns"])), self.arithmetic)


def averaged(values: np.ndarray, columns: Sequence[str], arithmetic: bool = False) -> np.ndarray:
    """Means over scenes of measures (s, m, c), with Z-avg as one measure more: (m, c + 1)."""
    means = mean_over_scenes(values, columns, arithmetic=arithmetic)
    return np.column_stack([means, depth_average(means, columns)])


def page(experiment: FusionExperiment) -> str:
    """The whole page."""
    e = experiment
    parts = [held_to(e), *thesis_sections(e), methods_section(e), lambda_section(e), *sweep_sections(e)]
    parts += [confidence_section(e), *surface_sections(e), *scale_space_sections(e), credits_section(e.credits)]
    return page_of("fusion", e.title, e.lead, *parts)


def held_to(e: FusionExperiment) -> Markup | None:
    """What was to be reached, and what was."""
    standings = [_standing(e, bar) for bar in e.bars]
    lead = "At the automatic λ, on average over the scenes."
    return bars_section(standings, e.default, ("",), least=True, lead=lead)


def _standing(e: FusionExperiment, bar: Bar) -> Standing:
    """A measure that ends in "/ median" is taken relative to the median's."""
    (name,) = bar.measure
    measure = name.removesuffix(" / median")
    unit = e.mean("median", measure) if name.endswith("/ median") else 1.0
    reached = {method: e.mean(method, measure) / unit for method in e.methods}
    known = {method: value for method, value in reached.items() if np.isfinite(value)}
    return Standing(bar, (name,), float(bar.bar), known)


def thesis_sections(e: FusionExperiment) -> list[Markup]:
    """The printed tables, each figure followed by ours."""
    parts = [part for printed in e.printed for part in (element("h3", printed.title), beside(e, printed))]
    return [section("Beside the thesis", *parts, lead=e.conventions)] if parts else []


def beside(e: FusionExperiment, printed: Printed) -> Markup:
    """Rows of the thesis with the name of ours; for each measure its figure and ours at the automatic lambda."""
    columns = printed.columns[2:]
    heads = [element("span", column, element("br"), side) for column in columns for side in ("thesis", "ours")]
    rows = []
    for name, ours, *values in printed.rows:
        cells = [
            cell
            for column, value in zip(columns, values, strict=True)
            for cell in (f"{float(value):g}", number(e.mean(ours, column)))
        ]
        rows.append((name, ours, *cells))
    return element("div", table(("", "ours", *heads), rows), class_="dense")


def methods_section(e: FusionExperiment) -> Markup:
    """All methods by all measures, at the automatic lambda; at the tuned one on demand."""
    scenes = ", ".join(map(str, e.table["scenes"]))
    kind = "Arithmetic" if e.arithmetic else "Geometric (of percentages: arithmetic)"
    lead = (
        f"{kind} means over {scenes}. centred RMSE, Z-MAE, N-MAE, Z-avg, out-3 and D-avg are the thesis' measures; "
        "RMSE and MAE are plain, "
        "and so is out-3 seen: of the pixels where all maps have a value, with no gap filled. "
        "AUSE: how far the order of the pixels by confidence, uncertainty or angle of view is from that by their "
        "errors, 0 the best. "
        "Bold: the best of a column."
    )
    tuned = [f"{method}{TUNED}" for method in e.methods if f"{method}{TUNED}" in map(str, e.table["methods"])]
    parts = [methods_table(e, e.methods)]
    parts += [details("The same at the tuned λ", methods_table(e, tuned))] if tuned else []
    return section("All methods", *parts, lead=lead)


def methods_table(e: FusionExperiment, methods: Sequence[str]) -> Markup:
    """A row for each of the methods, a column for each measure."""
    values = np.array([[e.mean(method, column) for column in e.columns] for method in methods])
    cells = [aligned(column) for column in values.T]
    rows = [(method.removesuffix(TUNED), *(column[r] for column in cells)) for r, method in enumerate(methods)]
    return table(("", *e.columns), rows, bold=best(values, e.columns))


def closeness(e: FusionExperiment) -> dict[str, float]:
    """For each method its error at the automatic lambda over that at the tuned one, on the scenes of the table."""
    ratios = {method: e.mean(method, e.measure) / e.mean(method + TUNED, e.measure) for method in e.methods}
    return {method: ratio for method, ratio in ratios.items() if np.isfinite(ratio)}


def lambda_section(e: FusionExperiment) -> Markup | None:
    """How the automatic lambda does against the tuned one, and the curves that it was tuned by."""
    ratios = closeness(e)
    if e.tuning is None or not ratios:
        return None
    close = sum(ratio <= fusion_tuning.WITHIN for ratio in ratios.values())
    own = (
        f" For the default, {e.default}, it is {number(ratios[e.default])} times the tuned one's."
        if e.default in ratios
        else ""
    )
    words = (
        f"On the scenes of the table the automatic λ gives {e.measure} within 10 % of the tuned λ for {close} of "
        f"{len(ratios)} methods.{own}"
    )
    best = dict(zip(map(str, e.tuning["methods"]), map(float, e.tuning["best"]), strict=True))
    automatic = dict(
        zip(map(str, e.tuning["methods"]), np.exp(np.log(e.tuning["automatic_lambda"]).mean(axis=0)), strict=True)
    )
    rows = [
        (
            method,
            number(float(automatic[method])),
            number(e.mean(method, e.measure)),
            number(best[method]),
            number(e.mean(method + TUNED, e.measure)),
            number(ratio),
            "yes" if ratio <= fusion_tuning.WITHIN else "no",
        )
        for method, ratio in ratios.items()
    ]
    heads = ("", "automatic λ", f"{e.measure}", "tuned λ", f"{e.measure}", "ratio", "within 10 %")
    curves = fusion_tuning.plots(e.tuning, *fusion_tuning.measured(e.tuning))
    scenes = ", ".join(map(str, e.tuning["scenes"]))
    shown = details(
        f"{e.measure} against λ on the development scenes ({scenes}); rings: the automatic λ",
        element("div", *curves, class_="plots"),
    )
    lead = f"λ was tuned for {e.measure} on {scenes}, which are not in the table."
    return section(
        "The automatic and the tuned λ", element("p", words, class_="lead"), table(heads, rows), shown, lead=lead
    )


def sweep_charts(e: FusionExperiment, measure: str) -> list[Chart]:
    """A chart for each sweep: error of each method against what is varied."""
    charts = []
    for sweep, settings in e.sweeps.items():
        lines: dict[str, list[tuple[float, float]]] = {}
        for value, trials in sorted(settings.items()):
            for method, error in _swept(trials, measure).items():
                lines.setdefault(method, []).append((value, error))
        curves = {name: np.array(points).T for name, points in lines.items()}
        series = tuple(Series(name, x, y, dots=True) for name, (x, y) in curves.items())
        charts.append(Chart(sweep.capitalize(), SWEEPS.get(sweep, sweep), measure, series[:SHOWN]))
    return charts


def _swept(trials: Sequence[Arrays], measure: str) -> dict[str, float]:
    """Mean error over scenes of every method at one setting; single views and means are off the chart and left out."""
    columns = [str(name) for name in trials[0]["columns"]]
    means = averaged(np.stack([one["values"] for one in trials]), columns)[:, [*columns, "Z-avg"].index(measure)]
    return {
        str(name): float(mean)
        for name, mean in zip(trials[0]["methods"], means, strict=True)
        if str(name) not in ("reference", "mean")
    }


def sweep_sections(e: FusionExperiment) -> Iterator[Markup]:
    """Average depth error (figures 4.3 and 4.5) and disparity error (4.4 and 4.6) against each setting."""
    if not e.sweeps:
        return
    figures = {
        "Z-avg": "Depth error against noise, number and spacing of the views (thesis figures 4.3, 4.5)",
        "D-avg px": "Disparity error against the same (thesis figures 4.4, 4.6)",
    }
    lead = (
        "At the automatic λ; geometric means over the scenes swept. Z-avg: geometric mean of centred RMSE, Z-MAE and "
        "N-MAE."
    )
    for measure, title in figures.items():
        yield section(
            title, element("div", *(chart.svg() for chart in sweep_charts(e, measure)), class_="plots"), lead=lead
        )


def confidence_chart(e: FusionExperiment) -> Chart | None:
    """Sparsification curves by the uncertainty of the methods whose maps were kept, averaged over the scenes."""
    if not e.scenes:
        return None
    first = next(iter(e.scenes.values()))
    lines: list[Series] = []
    for row, (name, rule) in enumerate(zip(first["methods"], first["rules"], strict=True)):
        if str(rule) == "automatic" and str(name) in map(str, first["maps"]) and len(lines) < SHOWN - 1:
            kept = np.mean(
                [scene.get("kept_error_uncertainty", scene["kept_error"])[row] for scene in e.scenes.values()], axis=0
            )
            lines.append(Series(str(name), np.linspace(100 / kept.size, 100, kept.size), kept))
            least = np.mean([scene["least_error"][row] for scene in e.scenes.values()], axis=0)
    if not lines:
        return None
    lines.append(Series("best order", lines[-1].x, least, dashed=True))
    return Chart("Sparsification by uncertainty", "share of pixels kept, %", "error, mean errors", tuple(lines))


def confidence_section(e: FusionExperiment) -> Markup | None:
    """What the confidences are worth."""
    chart = confidence_chart(e)
    if chart is None:
        return None
    return section("What the confidence is worth", element("div", chart.svg(), class_="plots"), lead=SPARSIFICATION)


def surfaces(trials: Arrays) -> list[Panel]:
    """The kept maps and the truth in light, cut to what is known."""
    window = extent(trials["truth"])
    maps = [*zip(map(str, trials["maps"]), trials["depth"], strict=True), ("truth", trials["truth"])]
    return [Panel(name, lights(depth, trials["truth"], trials["intrinsics"])[window], SHADE) for name, depth in maps]


def surface_sections(e: FusionExperiment) -> Iterator[Markup]:
    """Surfaces by different methods (figures 4.8 to 4.10)."""
    rows = []
    for name, trials in e.scenes.items():
        shown = surfaces(trials)
        wide = shown[0].values.shape[1] > 1.9 * shown[0].values.shape[0]
        rows += [
            element("h3", name),
            gallery(*(panel.figure() for panel in shown), columns=2 if wide else 4, small=True),
        ]
    if rows:
        yield section(
            "Surfaces (thesis figures 4.8 to 4.10)",
            *rows,
            lead="Every map at the automatic λ, in the same light. Hatched: not known.",
        )


def scale_space(panels: Arrays) -> dict[str, list[Panel]]:
    """Panels of figures 4.1 and 4.2, from arrays named `FIGURE LETTER CAPTION`."""
    groups: dict[str, list[tuple[str, np.ndarray]]] = {}
    for key in sorted(panels):
        number, _, caption = key.split(" ", 2)
        groups.setdefault(number, []).append((caption, panels[key]))
    drawn = {}
    for name, members in groups.items():
        depth = robust([members[0][1]], "turbo")
        drawn[name] = [
            Panel(caption, values, robust([values], "viridis") if caption.startswith("confidence") else depth)
            for caption, values in members
        ]
    return drawn


CAPTIONS = {
    "4.1": "TV-L1 of one image. By an even confidence c a box goes all at once when c falls below about 4 over its "
    "side, whatever its height; "
    "by one that varies in space the smallest stays where the large ones would go, and the other way round.",
    "4.2": "Eleven depth maps of one camera, the right half three times as noisy. By an even confidence (λ) one half "
    "is smoothed too much "
    "or the other too little; an estimated one tells them apart. The weak prior is that of the authors' code, the "
    "other our default.",
}


def scale_space_sections(e: FusionExperiment) -> Iterator[Markup]:
    """What the confidence does to the scale (figures 4.1 and 4.2)."""
    for name, shown in scale_space(e.panels).items():
        yield section(
            f"Scale and confidence (thesis figure {name})",
            gallery(*(panel.figure() for panel in shown), columns=4, small=True),
            lead=CAPTIONS.get(name, ""),
        )
