"""The views of a fusion, each read when it is asked for."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from typing import Any

import numpy as np

from ipcli.io.files.scratch import ScratchFiles
from ipcli.measurements.views import View, Views
from ipcli.models.fusion.windows import Window

KEPT = ("depth", "confidence")  # of a view, in scratch files


class ViewsOnDemand(Sequence[View]):
    """The views of these names (K), each read when it is asked for; without pictures, but for the reference, which is
    at hand.

    With scratch files each is read from its source once: `part` reads but a rectangle of it then.
    """

    def __init__(self, source: Views, names: Sequence[str], reference: View, scratch: ScratchFiles | None = None):
        self._source, self._names, self._reference, self._scratch = source, names, reference, scratch
        self._cameras: dict[str, View] = {}  # without depth

    def __len__(self) -> int:
        return len(self._names)

    def __getitem__(self, k: Any) -> Any:
        if not 0 <= k < len(self._names):
            raise IndexError(k)
        return self.part(k, Window(slice(0, None), slice(0, None)))

    def part(self, k: int, window: Window) -> View:
        """A rectangle of view k, as the view that sees but that."""
        name = self._names[k]
        if name == self._reference.name:
            return window.camera(self._reference)
        if self._scratch is None:
            return window.camera(self._source.load(name, pictures=False))
        if name not in self._cameras:
            return window.camera(self._stored(name, self._scratch))
        own = self._cameras[name]
        depth, confidence = (
            self._scratch.get((name, field), window.rows, window.columns) if (name, field) in self._scratch else None
            for field in KEPT
        )
        assert depth is not None
        return replace(own, depth=depth, confidence=confidence, intrinsics=window.camera_of(own.intrinsics))

    def _stored(self, name: str, scratch: ScratchFiles) -> View:
        """The view from its source; what it says is in scratch files from then on."""
        view = self._source.load(name, pictures=False)
        for field in KEPT:
            array = getattr(view, field)
            if array is not None:
                scratch.put((name, field), array)
        self._cameras[name] = replace(view, depth=np.empty((0, 0), np.float32), confidence=None)
        return view
