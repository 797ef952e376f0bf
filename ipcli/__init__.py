"""Vision problems solved by regularisation and Bayesian inference; what a notebook calls is in `ipcli.api`.

Importing the package imports nothing else: its functions are loaded when they are first asked for.
"""

from importlib import import_module
from typing import Any

__version__ = "0.1.0"
__all__ = ["ActionModel", "Result", "__version__", "fuse", "learn", "open", "read", "recognise"]


def __getattr__(name: str) -> Any:
    if name not in __all__:
        raise AttributeError(f"module 'ipcli' has no attribute {name!r}")
    return getattr(import_module("ipcli.api"), name)


def __dir__() -> list[str]:
    return __all__
