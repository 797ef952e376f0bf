"""One camera for each image of the reference pose."""

from __future__ import annotations

from collections.abc import Sequence

from ipcli.errors import ParameterError
from ipcli.geometry.orthographic import Orthographic, named
from ipcli.measurements.part_images import PartImage, PartTree
from ipcli.models.animal.cameras import align
from ipcli.models.animal.parameters import Modelling


def placed(images: Sequence[PartImage], tree: PartTree, params: Modelling) -> list[Orthographic]:
    """Cameras of all images. Those with a named view get their scale and shift from the silhouettes."""
    if any(image.view is None for image in images):
        raise ParameterError("an image of the reference pose has no view")
    return align([image.silhouette for image in images], [named(image.view) for image in images])
