"""Chapter 7 measured: every method on every case, as CSV, JSON and a page with the bars.

python -m experiments.brdf.page mit|diligent|synthetic|traced|painted|reliefs|development|rims|materials --library FILE
    -o FOLDER [--data FOLDER] [--quick] [--only METHOD ...] [--cases WORD] [--every N] [--draws N]
    [--patches none]
"""

from __future__ import annotations

import argparse
import json
import time
from collections.abc import Callable, Iterator, Sequence
from dataclasses import asdict, replace
from itertools import islice, product
from pathlib import Path

import numpy as np

from experiments.brdf import development, looks, painted, reliefs, rims, scenes, traced
from experiments.brdf.scenes import Case
from experiments.kit.tables import write_table
from ipcli.io.files import atomic, h5
from ipcli.models.brdf import energy, evaluation, grid, solid
from ipcli.models.brdf import scenes as generated
from ipcli.models.brdf.library import Library
from ipcli.models.brdf.parameters import Inference
from ipcli.models.brdf.reconstruct import baselines, reconstruct
from ipcli.report.brdf.brdf_object import TIED
from ipcli.report.kit.numbers import number
from ipcli.report.kit.page import page, section, table
from ipcli.rng import stream

BARS = {
    "mit": "geometric means over the five: Z-MAE 8.8 px and N-MAE .264 rad; flat 15.7 / .623, inflation 14.6 / "
    ".381, SIFS 21.8 / .412, thesis 7.02 / .269",
    "diligent": "mean 22.5 degrees; inflation 24.1, SIFS 44.9 (means of the objects)",
    "synthetic": "N-MAE below inflation's: plastics by 25 %, metals by 5 %",
    "traced": "none; those of synthetic hold for pictures by our own forward model",
    "painted": "mean at most 2 degrees above inflation's",
    "reliefs": "light from above: the sign right in 90 % of the area; what the picture does not settle is reported so",
    "development": "none: what parameters are chosen on",
    "rims": "none: what the judge of rims was chosen on",
    "materials": "1 of 5 in colour: 70 %; metal or not: 90 %",
}

EACH = (  # shown for each object
    "flat",
    "inflation",
    "ours",
    "always a solid",
    "true rim",
    "sign told where it ties",
    "true map, as a solid",
    "no patches, as a solid",
)

READERS: dict[str, Callable[[Path], Iterator[Case]]] = {
    "mit": scenes.mit,
    "diligent": scenes.diligent,
    "development": development.with_solids,
}


def cases(study: str, data: Path, shelf: Library, metals: np.ndarray, quick: bool, draws: int = 1) -> Iterator[Case]:
    """The cases of a study; the quick ones are generated and need no data. `metals` (b,) marks the shelf's."""
    if study == "synthetic":
        yield from synthetic(shelf, metals, quick, draws)
    elif study == "painted":
        yield from painted.cases(shelf, ~metals, quick)
    elif quick:
        rng = stream(7, "experiment", study)
        for number_ in range(4):
            made = generated.surface(rng, 96, sheets=0.5)
            taken = generated.scene(made, shelf.charts, rng)
            yield Case(f"scene {number_}", made.name, taken.picture, made.mask, made.normals, made.height)
    else:
        yield from READERS[study](data)


def synthetic(shelf: Library, metals: np.ndarray, quick: bool, draws: int = 1) -> Iterator[Case]:
    """Five objects in every material, each under a light that is drawn by its name; all over again for further draws,
    which are summed up by themselves.
    """
    objects = scenes.own(128 if quick else 192)
    for draw, (name, made) in product(range(1, draws + 1), objects.items()):
        of_draw = f", draw {draw}" if draw > 1 else ""
        for index, material in enumerate(shelf.materials[: 1 if quick else None]):
            rng = stream(7, "synthetic", f"{name} {material}{of_draw}")
            chart = shelf.charts[int(rng.choice(np.flatnonzero(shelf.material == index)))]
            yield Case(
                f"{name} {material}{of_draw}",
                material,
                generated.photograph(made, chart, rng),
                made.mask,
                made.normals,
                made.height,
                ("Metals" if metals[index] else "Plastics") + of_draw,
            )


def true_map(case: Case, params: Inference) -> np.ndarray:
    """The bound: the shape found when the map is fitted to the true normals (harmonics of order 2, as ours)."""
    small = solid.pictured(case.colour, case.mask, params.side)
    known = np.where(case.mask[..., None], np.nan_to_num(case.normals), 0)
    shrunk, _ = solid.shrink(known, case.mask, params.side)
    n = small.grid.on_cells(shrunk[small.grid.mask])
    n = n / np.maximum(np.linalg.norm(n, axis=1, keepdims=True), 1e-9)
    reflects = solid.fit_harmonics(small.intensity, n, params.solid.ridge)
    problem = energy.ShadedProblem(
        small.grid,
        small.intensity,
        small.inflated,
        energy.cell_normals(small.grid, small.inflated),
        params.solid.weights,
    )
    height = energy.gauss_newton(problem, reflects, 1.0, small.inflated, 30)
    return grid.inflate(case.mask) + solid.enlarge(height - small.inflated, small.grid.mask, case.mask)


def ablations(params: Inference) -> dict[str, Inference]:
    """What is asked of every picture as if it were a solid: ours, and ours with one thing more or less (table 7.2)."""
    solid_ = replace(params, rim="solid")

    def without(term: str) -> Inference:
        weights = replace(params.solid.weights, **{term: 0.0})
        return replace(solid_, solid=replace(params.solid, weights=weights))

    return {
        "always a solid": solid_,
        "no forces (prior normals), as a solid": without("normal"),
        "no smoothing (bending), as a solid": without("bending"),
        "convex refinement, as a solid": replace(solid_, refine="convex"),
        "no patches, as a solid": replace(solid_, use_patches="none"),
    }


def measured(case: Case, shelf: Library, params: Inference, only: Sequence[str] = ()) -> dict[str, list[float]]:
    """[N-MAE, median, Z-MAE, seconds] of every method on a case, or of what is `judged` if ours is named, and of the
    `ablations` that are.
    """
    found = {name: [*errors_of(shape, case), np.nan] for name, shape in baselines(case.mask).items()}
    if not only or "ours" in only:
        found |= judged(case, shelf, params, found["inflation"][0])
    for name, asked in ablations(params).items():
        if name not in found and (not only or name in only):
            height = reconstruct(case.colour, case.mask, shelf, asked).height
            found[name] = [*errors_of(height, case), np.nan]
    print(f"{case.name}: " + ", ".join(f"{k} {v[0]:.3f}" for k, v in found.items()), flush=True)
    return found


def judged(case: Case, shelf: Library, params: Inference, inflation: float) -> dict[str, list[float]]:
    """The same of ours and of what comes with it, and of ours when the rim, the map or, of a hollow whose picture does
    not settle it, the sign is told; `inflation` is its N-MAE.
    """
    started = time.monotonic()
    ours = reconstruct(case.colour, case.mask, shelf, params)
    seconds = time.monotonic() - started
    shapes = {"ours": ours.height, "contour only": ours.prior}
    if ours.solid_height is not None:
        shapes["always a solid"] = ours.solid_height
    if ours.sheet_height is not None:
        shapes["always a sheet"] = ours.sheet_height
    flattened, hollow = (errors_of(k * grid.inflate(case.mask), case)[0] for k in (params.sheet.relief, -1.0))
    rim, known = ("sheet", ours.sheet_height) if flattened < inflation else ("solid", ours.solid_height)

    def told(rim: str, relief: str) -> np.ndarray:
        return reconstruct(case.colour, case.mask, shelf, replace(params, rim=rim, relief=relief)).height

    shapes["true rim"] = told(rim, params.relief) if known is None else known
    is_unsettled = hollow < inflation and abs(ours.tie) < TIED
    shapes["sign told where it ties"] = told(params.rim, "concave") if is_unsettled else ours.height
    shapes["true map, as a solid"] = true_map(case, params)
    return {name: [*errors_of(shape, case), seconds if name == "ours" else np.nan] for name, shape in shapes.items()}


def errors_of(shape: np.ndarray, case: Case) -> list[float]:
    """`evaluation.COLUMNS` of a surface."""
    return evaluation.errors(shape, case.mask, case.normals, case.height)


def summary(study: str, rows: dict[str, dict[str, list[float]]]) -> list[list[str]]:
    """A line a method: geometric means for MIT, else means; only methods that every case has."""
    methods = [m for m in next(iter(rows.values())) if all(m in row for row in rows.values())]
    lines = []
    for method in methods:
        values = np.array([rows[name][method][:3] for name in rows])
        mean = np.exp(np.log(values).mean(axis=0)) if study == "mit" else values.mean(axis=0)
        worse = sum(rows[name][method][0] > rows[name]["inflation"][0] + np.radians(2) for name in rows)
        relative = mean[0] / (
            np.exp(np.log([rows[n]["inflation"][0] for n in rows]).mean())
            if study == "mit"
            else np.mean([rows[n]["inflation"][0] for n in rows])
        )
        lines.append(
            [
                method,
                number(mean[0]),
                number(np.degrees(mean[0])),
                number(mean[2]),
                f"{100 * (relative - 1):+.0f} %",
                f"{worse} of {len(rows)}",
            ]
        )
    return lines


def per_group(rows: dict[str, dict[str, list[float]]], groups: dict[str, str]) -> list[list[str]]:
    """A line an object (or material): N-MAE in radians of the methods of `EACH` that are there."""
    methods, lines = each_of(rows), []
    for group in dict.fromkeys(groups.values()):
        mine = [rows[name] for name in rows if groups[name] == group]
        lines.append(
            [
                group,
                *(number(float(np.mean([row[m][0] for row in mine]))) for m in methods),
            ]
        )
    return lines


def each_of(rows: dict[str, dict[str, list[float]]]) -> list[str]:
    """The methods that are shown for each object."""
    return [m for m in EACH if all(m in row for row in rows.values())]


def write(
    folder: Path,
    study: str,
    rows: dict[str, dict[str, list[float]]],
    groups: dict[str, str],
    kinds: dict[str, str],
) -> None:
    """CSV, JSON and the page; of each case by name its rows of figures, its group and its kind."""
    columns = ("n_mae_rad", "n_median_rad", "z_mae_px", "seconds")
    lines = [
        {"case": name, "kind": kinds[name], "method": method} | dict(zip(columns, values, strict=True))
        for name, row in rows.items()
        for method, values in row.items()
    ]
    write_table(folder / "errors.csv", lines, study=study)
    heads = ("Method", "N-MAE, rad", "degrees", "Z-MAE, px", "against inflation", "worse by 2° or more")
    parts = []
    for kind in dict.fromkeys(kinds.values()):
        means = summary(study, {name: row for name, row in rows.items() if kinds[name] == kind})
        print(kind, *("  ".join(line) for line in means), sep="\n")
        parts.append(section(kind, table(heads, means), lead=f"Bar: {BARS[study]}."))
    parts += [
        section(
            "Each object",
            table(("Object", *each_of(rows)), per_group(rows, groups)),
            lead="N-MAE, rad.",
        ),
    ]
    verdict = f"{len(rows)} pictures"
    if seconds := [row["ours"][3] for row in rows.values() if "ours" in row]:
        verdict += f"; {np.median(seconds):.1f} s each on the median, {max(seconds):.1f} s at most"
    atomic.write_text(
        folder / "index.html", page(f"Surfaces from one picture: {study}", "experiments/brdf", verdict + ".", *parts)
    )


def materials(folder: Path, arrays: dict[str, np.ndarray], quick: bool) -> None:
    """What the library says of pictures of held-out surfaces under held-out probes, and what patches alone would."""
    right, metal = (float(v) for v in arrays["material_accuracy"])
    facts = {"material right": right, "metal or not right": metal, "rims right": float(arrays["rim_accuracy"])}
    atomic.write_text(folder / "accuracy.json", json.dumps(facts, indent=1) + "\n")
    rows = [(name, f"{100 * value:.1f} %") for name, value in facts.items()]
    print("  ".join(f"{name} {value}" for name, value in rows))
    part = section("Generated pictures", table(("Question", "right"), rows), lead=f"Bar: {BARS['materials']}.")
    told = looks.shares(Library.of(arrays), arrays["is_metal"] > 0, quick)
    ways = [(name, *(f"{100 * share:.1f} %" for share in pair)) for name, pair in told.items()]
    print(*("  ".join(way) for way in ways), sep="\n")
    write_table(folder / "looks.csv", [{"way": n, "material": m, "metal": k} for n, (m, k) in told.items()])
    by_patches = section(
        "By patches",
        table(("Told by", "material", "metal or not"), ways),
        lead="Codes of a stacked sparse autoencoder a material (thesis 7.2); surfaces and probes that neither coders "
        "nor their spreads have seen. Learnt: linear discriminants on pictures of other surfaces under other probes. "
        "The last line has seen these probes.",
    )
    atomic.write_text(
        folder / "index.html",
        page("Materials from one picture", "experiments/brdf", "Surfaces and probes held out.", part, by_patches),
    )


def write_reliefs(folder: Path, found: list[reliefs.Told]) -> None:
    """CSV, JSON and page of which way reliefs were said to bend."""
    write_table(folder / "reliefs.csv", [asdict(one) for one in found], study="reliefs")
    columns = (
        "Of",
        "light from",
        "reliefs",
        "area of the right sign by light-above",
        "all taken as convex",
        "reported as open",
    )
    parts = []
    for title, key in (("All", "kind"), ("Each", "name")):
        rows = []
        for of, light in dict.fromkeys((getattr(one, key), one.light) for one in found):
            mine = [one for one in found if (getattr(one, key), one.light) == (of, light)]
            shares = (
                float(np.mean([getattr(one, of_what) for one in mine])) for of_what in ("right", "convex", "ties")
            )
            rows.append((of, light, str(len(mine)), *(f"{100 * share:.0f} %" for share in shares)))
            print(*rows[-1], sep="  ")
        parts.append(section(title, table(columns, rows), lead=f"Bar: {BARS['reliefs']}."))
    verdict = f"{len({one.name for one in found})} reliefs, each under three lights."
    atomic.write_text(folder / "index.html", page("Which way it bends", "experiments/brdf", verdict, *parts))


def main() -> None:
    """Run one study."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("study", choices=tuple(BARS))
    parser.add_argument("--library", type=Path, required=True)
    parser.add_argument("--data", type=Path, default=Path("../shared/data"))
    parser.add_argument("-o", "--output", type=Path, required=True)
    parser.add_argument("--quick", action="store_true")
    parser.add_argument("--only", nargs="+", default=(), choices=("ours", *ablations(Inference())), help="these alone")
    parser.add_argument("--cases", default="", metavar="WORD", help="only the pictures that have it in their name")
    parser.add_argument(
        "--every", type=int, default=1, help="one case of so many; 5: one mix of each object of diligent"
    )
    parser.add_argument("--draws", type=int, default=1, help="times that lights are drawn anew for synthetic")
    parser.add_argument("--patches", default=Inference().use_patches, choices=("none", "prior"), help="as brdf-model")
    given = parser.parse_args()
    arrays = h5.read(given.library, "brdf-library").arrays
    if given.study == "materials":
        materials(given.output, arrays, given.quick)
        return
    shelf, params = Library.of(arrays), replace(Inference(), use_patches=given.patches)
    if given.study == "traced":
        traced.write(given.output, list(traced.measured(shelf, params, given.quick)))
        return
    if given.study == "rims":
        rims.write(given.output, rims.measured(given.data, shelf, given.quick))
        return
    if given.study == "reliefs":
        write_reliefs(given.output, list(reliefs.measured(shelf, given.quick)))
        return
    rows, groups, kinds = {}, {}, {}
    found = cases(given.study, given.data, shelf, arrays["is_metal"] > 0, given.quick, given.draws)
    for case in islice((one for one in found if given.cases in one.name), 0, None, given.every):
        rows[case.name], groups[case.name] = measured(case, shelf, params, given.only), case.group
        kinds[case.name] = case.kind
    write(given.output, given.study, rows, groups, kinds)


if __name__ == "__main__":
    main()
