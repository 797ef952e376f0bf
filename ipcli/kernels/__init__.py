"""Inner loops compiled by numba, and nothing else; every kernel has a plain NumPy twin in tests/kernels.

The compiled code is cached in a folder named after the version and the sources of this package, chosen here,
before numba is imported: a kernel edited in one file can then never meet a stale caller in another, and an
installation that is read-only still caches.
"""

import hashlib
import os
from pathlib import Path

from ipcli import __version__


def cache_folder() -> Path:
    """The folder of compiled kernels: one per version of ipcli and per state of the sources in this package."""
    sources = hashlib.sha256()
    for source in sorted(Path(__file__).parent.glob("*.py")):
        sources.update(source.read_bytes())
    root = Path(os.environ.get("XDG_CACHE_HOME") or Path.home() / ".cache")
    return root / "ipcli" / f"kernels-{__version__}-{sources.hexdigest()[:16]}"


os.environ.setdefault("NUMBA_CACHE_DIR", str(cache_folder()))
