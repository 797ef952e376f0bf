"""What `import ipcli` offers in a notebook: open measurements, work on them, look at results.

    views = ipcli.open("sample_data/shapes")            # depth maps, read when they are needed
    fused = ipcli.fuse(views, reference="005")          # a result: fused["depth"], a page in a notebook
    fused.save("shapes.fused.h5")                       # the artefact that fuse-depth writes

    clips = ipcli.open("sample_data/motions")           # motions with their actions and people
    model = ipcli.learn(clips, actors=("ann", "bob"))
    told = model.recognise(clips, actors=("eve",))      # told["answers"]

    fused = ipcli.read("shapes.fused.h5")               # any artefact

Settings have the names that the commands' --set takes, with or without their section (`method=...`, `lam=...`,
`solver={"iterations": 50}`); an unknown one is an error that names the nearest. Errors are those of `ipcli.errors`.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from html import escape
from pathlib import Path
from typing import Any

import numpy as np

from ipcli import report, schema
from ipcli.errors import FormatError, OutputExists, ParameterError, nearest
from ipcli.io.files import atomic, h5
from ipcli.io.motion import layouts as motion_layouts
from ipcli.io.views import layouts as view_layouts
from ipcli.measurements.motions import Clips
from ipcli.measurements.names import window as names_around
from ipcli.measurements.views import Views
from ipcli.models.mocap.behaviours import body_of_arrays
from ipcli.models.mocap.motions import of_people, select
from ipcli.models.mocap.training import learn_behaviours
from ipcli.params import as_dict, leaves, resolve
from ipcli.progress import Progress, silent
from ipcli.provenance import record
from ipcli.stages.fusion.fuse_depth import fused_arrays, reference_of
from ipcli.stages.fusion.parameters import FuseDepth
from ipcli.stages.fusion.sources import middle
from ipcli.stages.mocap.mocap_classify import recognised_arrays
from ipcli.stages.mocap.parameters import MocapClassify, MocapTrain
from ipcli.stages.mocap.reading import gather

HEIGHT = 640  # pixels of a page within a notebook
SHOWN = 4  # fields that a short description names


@dataclass(frozen=True, eq=False, repr=False)
class Result(Mapping[str, np.ndarray]):
    """An artefact in memory: its arrays by name, of the shapes, units and meaning that docs/formats.md lists."""

    kind: str
    arrays: dict[str, np.ndarray]
    provenance: dict[str, Any]

    def __getitem__(self, name: str) -> np.ndarray:
        return self.arrays[name]

    def __iter__(self) -> Iterator[str]:
        return iter(self.arrays)

    def __len__(self) -> int:
        return len(self.arrays)

    def __repr__(self) -> str:
        largest = sorted(self.arrays, key=lambda name: -self.arrays[name].size)[:SHOWN]
        shown = ", ".join(f"{name} {' x '.join(map(str, self.arrays[name].shape))}" for name in largest)
        return f"{type(self).__name__}({self.kind}: {shown}, ...; {len(self)} arrays)"

    def page(self) -> str:
        """The HTML page of the artefact, as the command writes it. ParameterError for a kind without one."""
        return report.renderer(self.kind)(self.arrays, self.provenance)

    def _repr_html_(self) -> str | None:
        if not report.has_page(self.kind):
            return None
        return f'<iframe srcdoc="{escape(self.page())}" style="width:100%;height:{HEIGHT}px;border:0"></iframe>'

    def save(self, path: str | Path) -> Path:
        """Write the artefact to a new file X.h5; OutputExists when there is one of that name."""
        output = Path(path)
        if output.suffix != ".h5":
            raise ParameterError(f"{output}: an artefact is written as X.h5. Give such a name")
        with atomic.drafting(output) as draft:
            h5.write(draft, self.kind, self.arrays, self.provenance)
            try:
                atomic.publish(draft, output, replace=False)
            except FileExistsError:
                raise OutputExists(output, "is not replaced from Python") from None
        return output


class ActionModel(Result):
    """What `learn` learnt: the behaviours of every action in every group of joints."""

    def recognise(self, clips: Clips | str | Path, *, rate: float = 30.0, seed: int = 0, **settings: Any) -> Result:
        """Name the action of each clip, or with `window=1.0` along each; an `action-recognition` result.

        Raises FormatError for clips of another skeleton, NoSolution when no frame shows a group of joints whole.
        """
        params = _resolved(MocapClassify, ("decision",), settings)
        body = body_of_arrays(self.arrays, "model")
        known = of_people(gather([_clips(clips)], rate, body.groups, body.skeleton), params.actors)
        stored = h5.Artefact(self.kind, schema.kind(self.kind).version, self.arrays, self.provenance)
        arrays = recognised_arrays(stored, known, params, seed)
        return _result("action-recognition", "mocap-classify", arrays, params, seed)


def open(path: str | Path, **hints: Any) -> Views | Clips:
    """Depth views or clips of motion, whichever is at `path`, read only when they are needed.

    `hints` are those of the layout, such as `depth_scale=5000`. Raises FormatError when neither is there.
    """
    place = Path(path)
    families = ((view_layouts.LAYOUTS, view_layouts.open_views), (motion_layouts.LAYOUTS, motion_layouts.open_clips))
    if place.is_file() and place.suffix == ".h5":
        kind = h5.peek(place).kind
        if kind not in ("views", "clips"):
            raise FormatError(place, f"holds '{kind}', no measurements", fix="Read it with ipcli.read")
        return view_layouts.open_views(place) if kind == "views" else motion_layouts.open_clips(place)
    for layouts, opened in families:
        if place.exists() and any(
            one.recognise(place) for name, one in layouts.items() if name not in ("views", "clips")
        ):
            return opened(place, **hints)
    known = [one.looks_like for layouts, _ in families for one in layouts.values()]
    raise FormatError(place, f"neither depth views nor motions. Looked for {'; '.join(known)}", fix="Check the path")


def fuse(
    views: Views | str | Path, reference: str | None = None, *, progress: Progress = silent, **settings: Any
) -> Result:
    """Fuse depth maps into one of a reference view (the middle one if not given); a `fused-depth` result.

    Raises NoSolution when no view overlaps the reference.
    """
    source = view_layouts.open_views(Path(views)) if isinstance(views, (str, Path)) else views
    params = _resolved(FuseDepth, ("fusion",), settings | ({} if reference is None else {"reference": reference}))
    name = params.reference or middle(source.names)
    names = names_around(source.names, name, params.window or len(source.names))
    return _result(
        "fused-depth",
        "fuse-depth",
        fused_arrays(source, names, reference_of(source, name, params), params, progress),
        params,
        0,
    )


def learn(clips: Clips | str | Path, *, rate: float = 30.0, seed: int = 0, **settings: Any) -> ActionModel:
    """Learn from labelled clips how each part of the body behaves in each action; a `behaviours` result.

    Raises ParameterError for clips without labels.
    """
    params = _resolved(MocapTrain, ("learning", "decision"), settings)
    known = select(gather([_clips(clips)], rate, params.groups), params.actors, params.actions)
    arrays = learn_behaviours(known, params.learning, params.decision, seed)
    found = _result("behaviours", "mocap-train", arrays, params, seed)
    return ActionModel(found.kind, found.arrays, found.provenance)


def recognise(model: ActionModel | str | Path, clips: Clips | str | Path, **settings: Any) -> Result:
    """Name the actions of clips by a model or the file of one; see `ActionModel.recognise`."""
    known = model if isinstance(model, ActionModel) else read(model)
    if not isinstance(known, ActionModel):
        raise ParameterError(f"{model}: holds '{known.kind}', no model of actions. Give what mocap-train wrote")
    return known.recognise(clips, **settings)


def read(path: str | Path) -> Result:
    """Any artefact, whole and checked. Raises FormatError for other or damaged files."""
    place = Path(path)
    found = h5.read(place, h5.peek(place).kind)
    return (ActionModel if found.kind == "behaviours" else Result)(found.kind, found.arrays, found.provenance)


def _clips(clips: Clips | str | Path) -> tuple[Path, Clips]:
    if isinstance(clips, (str, Path)):
        return Path(clips), motion_layouts.open_clips(Path(clips))
    return Path("clips"), clips


def _resolved(cls: type, sections: Sequence[str], given: Mapping[str, Any]) -> Any:
    """The parameters of a command, from settings named with or without their section."""
    known = {leaf.key for leaf in leaves(cls)}
    flags = {}
    for key, value in _flat(given, ""):
        named = [name for name in (key, *(f"{section}.{key}" for section in sections)) if name in known]
        flags[named[0] if named else key] = value
    for key in flags:
        if key not in known:
            raise ParameterError(f"unknown setting '{key}'{nearest(key, known)}")
    return resolve(cls, flags=flags)


def _flat(given: Mapping[str, Any], prefix: str) -> Iterator[tuple[str, Any]]:
    for key, value in given.items():
        if isinstance(value, Mapping):
            yield from _flat(value, f"{prefix}{key}.")
        else:
            yield prefix + key, value


def _result(kind: str, command: str, arrays: dict[str, np.ndarray], params: Any, seed: int) -> Result:
    schema.validate(schema.kind(kind), arrays)
    return Result(kind, arrays, record(command, as_dict(params), (), kind, seed))
