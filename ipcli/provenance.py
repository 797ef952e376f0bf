"""What made an artefact. `record` is the part that repeats (and goes inside it), `run_record` the part that
does not.
"""

from __future__ import annotations

import hashlib
import json
import sys
from collections.abc import Iterable, Mapping, Sequence
from pathlib import Path
from typing import Any

from ipcli import __version__, schema
from ipcli.errors import IpcliError
from ipcli.inputs import check_file

BLOCK = 1 << 20
LIBRARIES = ("numpy", "scipy", "numba", "h5py", "opencv-python-headless", "open3d-cpu", "open3d", "pycolmap", "trimesh")


def sha256(path: Path | Sequence[Path]) -> str:
    """Hex digest of a file; of a folder by the relative names and contents of its visible files; of several by name.

    Neither the place of a folder nor the order of files changes it. Raises IpcliError when there is nothing to read.
    """
    if not isinstance(path, Path):
        return _combined((item.name, item) for item in path)
    if path.is_dir():
        names = ((item.relative_to(path), item) for item in path.rglob("*") if item.is_file())
        return _combined((name.as_posix(), item) for name, item in names if not any(p[0] == "." for p in name.parts))
    check_file(path)
    try:
        with path.open("rb") as stream:
            return hashlib.file_digest(stream, "sha256").hexdigest()
    except OSError as error:
        raise IpcliError(f"{path}: cannot be read: {error.strerror}") from error


def _combined(files: Iterable[tuple[str, Path]]) -> str:
    lines = sorted(f"{sha256(path)}  {name}\n" for name, path in files)
    return hashlib.sha256("".join(lines).encode("utf-8", "surrogateescape")).hexdigest()


def digest(params: Mapping[str, Any], inputs: Sequence[str], version: int, seed: int) -> str:
    """Hex digest of all that decides a result: parameters, digests of the inputs in order, schema version, seed."""
    decisive = {"params": params, "inputs": list(inputs), "version": version, "seed": seed}
    return hashlib.sha256(json.dumps(decisive, sort_keys=True, allow_nan=False).encode()).hexdigest()


def record(command: str, params: Mapping[str, Any], inputs: Sequence[Path], kind: str, seed: int) -> dict[str, Any]:
    """The deterministic record kept inside an artefact: no absolute path, no time, no host."""
    hashed = [{"name": path.name, "sha256": sha256(path)} for path in inputs]
    return {
        "command": command,
        "ipcli": __version__,
        "params": dict(params),
        "seed": seed,
        "inputs": hashed,
        "digest": digest(params, [item["sha256"] for item in hashed], schema.kind(kind).version, seed),
    }


def run_record(elapsed: float) -> dict[str, Any]:
    """What varies from run to run, for X.run.json: when, where, how long (s), peak memory (MB), versions,
    command line.
    """
    import platform
    from datetime import UTC, datetime

    return {
        "time": datetime.now(UTC).isoformat(timespec="seconds"),
        "host": platform.node(),
        "platform": platform.platform(),
        "elapsed_s": round(elapsed, 3),
        "max_rss_mb": _peak_memory(),
        "python": platform.python_version(),
        "libraries": _library_versions(),
        "argv": sys.argv,
    }


def _peak_memory() -> float | None:
    """Peak resident set of this process in MB, or None where the system does not tell (Windows)."""
    try:
        import resource
    except ImportError:
        return None
    per_megabyte = 1e6 if sys.platform == "darwin" else 1e3  # bytes there, kilobytes elsewhere
    return round(resource.getrusage(resource.RUSAGE_SELF).ru_maxrss / per_megabyte, 1)


def _library_versions() -> dict[str, str]:
    from importlib import metadata

    versions = {}
    for name in LIBRARIES:
        try:
            versions[name] = metadata.version(name)
        except metadata.PackageNotFoundError:
            continue
    return versions
