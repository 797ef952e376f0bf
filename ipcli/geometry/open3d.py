"""Open3D, also on machines that lack one of its system libraries."""

from __future__ import annotations

import ctypes
import sys
from ctypes.util import find_library
from types import ModuleType


def load() -> ModuleType:
    """Import and return ``open3d``.

    Its wheel links against libusb (for depth cameras), which bare servers and containers lack; there the copy inside
    the PyPI package ``libusb-package`` is loaded first, with global symbols so that the linker finds it.
    """
    if "open3d" not in sys.modules and find_library("usb-1.0") is None:  # the search starts two processes
        import libusb_package

        ctypes.CDLL(str(libusb_package.get_library_path()), mode=ctypes.RTLD_GLOBAL)
    import open3d

    return open3d
