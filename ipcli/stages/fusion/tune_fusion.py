"""tune-fusion: scenes with known truth -> the errors of every method over a grid of lambda, and the best of each."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from functools import partial
from pathlib import Path
from typing import TYPE_CHECKING

from ipcli.errors import ParameterError, nearest
from ipcli.params import Run, option
from ipcli.progress import Progress, silent
from ipcli.stages.fusion.scenes import Judged, Scene, Trials, Variant, open_scene

if TYPE_CHECKING:
    import numpy as np

    from ipcli.stages.kit.artefact import Outcome


@dataclass(frozen=True)
class Params(Trials):
    """The grid, and what counts as best on it."""

    lambdas: tuple[float, ...] = option(
        (0.07, 0.1, 0.14, 0.2, 0.28, 0.4, 0.56, 0.8, 1.6, 3.2, 6.4),
        "Values of lambda to try, besides the automatic one.",
        flag="--lambdas",
        low=1e-9,
    )
    measure: str = option("RMSE", "Measure that is to be least on average over the scenes.", flag="--measure")


def run(files: Sequence[Path], output: Path, params: Params, run: Run, progress: Progress = silent) -> Outcome:
    """Write the `tuning` artefact and beside it a page (.html). Raises ItemsFailed when some scenes failed."""
    from ipcli.stages.kit.artefact import Job, make
    from ipcli.stages.kit.pages import page

    if len(set(params.lambdas)) != len(params.lambdas) or params.fusion.lam is not None:
        raise ParameterError("give every lambda once, by --lambdas")
    if not any(variant.is_regularised for variant in params.variants):
        raise ParameterError("none of these methods has a lambda to tune")
    job = Job(output, "fusion-tuning", "tune-fusion", params, tuple(files), page(output, "fusion-tuning"))
    return make(job, lambda: tuning(files, params, run.executor, progress), run)


def tuning(files: Sequence[Path], params: Params, executor: str, progress: Progress) -> dict[str, np.ndarray]:
    """The arrays of the artefact; methods without regularisation are left out, there being nothing to tune."""
    import numpy as np

    from ipcli.executor import map_items
    from ipcli.report.fusion.averages import over_scenes

    swept = map_items(partial(sweep, params=params), [str(path) for path in files], executor, progress)
    columns = next(iter(swept.values()))["columns"]
    if params.measure not in columns:
        raise ParameterError(f"no measure '{params.measure}'{nearest(params.measure, columns)}")
    stacked = {
        key: np.stack([one[key] for one in swept.values()]) for key in ("values", "automatic", "automatic_lambda")
    }
    means = over_scenes(stacked["values"], columns)[..., list(columns).index(params.measure)]
    return stacked | {
        "scenes": np.array([path.name.split(".")[0] for path in files]),
        "methods": np.array([variant.label for variant in params.variants if variant.is_regularised]),
        "lambdas": np.array(sorted(params.lambdas)),
        "columns": columns,
        "measure": np.array(params.measure),
        "best": np.array(sorted(params.lambdas))[means.argmin(axis=1)],
    }


def sweep(name: str, *, params: Params) -> dict[str, np.ndarray]:
    """Every method at every lambda on the scene in file `name`; the errors of a method are taken on pixels that all its
    maps have.
    """
    import numpy as np

    scene = open_scene(Path(name), params)
    curves = [curve(scene, variant, params) for variant in params.variants if variant.is_regularised]
    columns = np.array(curves[0][0])
    automatic_lambda, automatic, values = (np.stack(parts) for parts in list(zip(*curves, strict=True))[1:])
    return {"columns": columns, "automatic_lambda": automatic_lambda, "automatic": automatic, "values": values}


def curve(scene: Scene, variant: Variant, params: Params) -> tuple[list[str], float, np.ndarray, np.ndarray]:
    """Columns, the automatic lambda, its errors (c,), and the errors (n, c) over the grid."""
    fused = [scene.fuse(variant, params.fusion, lam) for lam in (None, *sorted(params.lambdas))]
    columns, rows = scene.errors({str(index): Judged.of(one) for index, one in enumerate(fused)})
    return columns, float(fused[0].lam), rows[0], rows[1:]


def best_lambdas(path: Path) -> dict[str, float]:
    """The best lambda of each method label in a `tuning` artefact."""
    from ipcli.io.files import h5

    arrays = h5.read(path, "fusion-tuning", only=lambda name: name in ("methods", "best")).arrays
    return dict(zip(map(str, arrays["methods"]), map(float, arrays["best"]), strict=True))
