"""The list of materials and probes that brdf-train reads: a TOML file with a section a material and one for the
probes.
"""

from __future__ import annotations

import os
from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from ipcli.errors import FormatError, nearest
from ipcli.inputs import read_toml

MODELS = ("conductor", "plastic", "network", "abc", "table")
KEYS = {
    "conductor": ("eta", "kappa", "roughness"),
    "plastic": ("diffuse", "eta", "roughness"),
    "network": ("file", "name"),
    "abc": ("file", "name"),
    "table": ("file",),
}


@dataclass(frozen=True)
class Listed:
    """What the file says; paths are resolved against its folder."""

    materials: Mapping[str, Mapping[str, Any]]
    probes: Mapping[str, Path]

    def inputs(self, source: Path) -> tuple[Path, ...]:
        """All files that are read."""
        files = {Path(entry["file"]) for entry in self.materials.values() if "file" in entry}
        return (source, *sorted(files), *self.probes.values())


def read(path: Path) -> Listed:
    """The list. Raises FormatError for what is no TOML, no material, an unknown model or key, or a file that is not
    there.
    """
    tree = read_toml(path)
    unknown = set(tree) - {"materials", "probes"}
    if unknown:
        raise FormatError(path, f"unknown section '{min(unknown)}'{nearest(min(unknown), ['materials', 'probes'])}")
    materials = tree.get("materials")
    if (
        not isinstance(materials, dict)
        or len(materials) < 2
        or not all(isinstance(m, dict) for m in materials.values())
    ):
        raise FormatError(path, "names too few materials", expected="two sections [materials.NAME] or more")
    return Listed(
        {name: _material(path, name, entry) for name, entry in materials.items()}, _probes(path, tree.get("probes", {}))
    )


def _material(path: Path, name: str, entry: Mapping[str, Any]) -> dict[str, Any]:
    model = entry.get("model")
    if model not in MODELS:
        raise FormatError(path, f"materials.{name}: unknown model {model!r}", expected=", ".join(MODELS))
    needed = KEYS[model]
    given = set(entry) - {"model", "metal"}
    if given != set(needed):
        raise FormatError(
            path, f"materials.{name}: wrong keys", expected=", ".join(needed), got=", ".join(sorted(given)) or "none"
        )
    made = dict(entry)
    if "file" in made:
        made["file"] = str(_beside(path, made["file"], f"materials.{name}"))
    for key in set(needed) - {"file", "name"}:
        made[key] = _numbers(
            path,
            f"materials.{name}.{key}",
            made[key],
            3 if key in ("kappa", "diffuse") else 3 if model == "conductor" and key == "eta" else 1,
        )
    return made


def _numbers(path: Path, what: str, value: Any, count: int) -> Any:
    parts = value if isinstance(value, list) else [value]
    sound = len(parts) == count and all(
        isinstance(v, (int, float)) and not isinstance(v, bool) and 0 <= v < 1e3 for v in parts
    )
    if not sound or (what.endswith("roughness") and not 0.02 <= parts[0] <= 1):
        expected = "0.02 to 1" if what.endswith("roughness") else f"{count} number{'s' if count > 1 else ''} >= 0"
        raise FormatError(path, f"{what}: wrong value", expected=expected, got=value)
    return tuple(map(float, parts)) if count > 1 else float(parts[0])


def _probes(path: Path, entry: Any) -> dict[str, Path]:
    if not isinstance(entry, dict) or set(entry) - {"files"} or not isinstance(entry.get("files", []), list):
        raise FormatError(path, "probes: wrong section", expected='files = ["a.hdr", ...]')
    files = [_beside(path, name, "probes") for name in entry.get("files", [])]
    names = [file.stem for file in files]
    if len(set(names)) != len(names):
        raise FormatError(
            path, "two probes have one name", got=", ".join(sorted({n for n in names if names.count(n) > 1}))
        )
    return dict(zip(names, files, strict=True))


def _beside(path: Path, name: Any, what: str) -> Path:
    if not isinstance(name, str) or "\0" in name:
        raise FormatError(path, f"{what}: not the name of a file", got=repr(name))
    found = path.parent / name
    if not os.path.isfile(found):  # no error, as Path's has, for a name that no file can have
        raise FormatError(path, f"{what}: no such file as {found}")
    return found


def brdf(entry: Mapping[str, Any]) -> Any:
    """The reflectance of an entry of the list."""
    from ipcli.io.materials import measured
    from ipcli.models.brdf import materials as models

    if entry["model"] == "conductor":
        return models.Conductor(entry["eta"], entry["kappa"], entry["roughness"])
    if entry["model"] == "plastic":
        return models.Plastic(entry["diffuse"], entry["eta"], entry["roughness"])
    file = Path(entry["file"])
    if entry["model"] == "network":
        return models.Network(measured.read_network(file, entry["name"]))
    if entry["model"] == "abc":
        return models.Abc(**measured.read_abc(file, entry["name"]))
    return models.Table(measured.read_table(file))


def is_metal(entry: Mapping[str, Any]) -> bool:
    """What the list says, or that the model is a conductor."""
    return bool(entry.get("metal", entry["model"] == "conductor"))
