"""Where the surface jumps: weights that let the regulariser go there and hold the rest together the more.

The first-order term |grad x - v| of TGV charges a jump by its height, which pulls both sides of an edge together. A
penalty that is concave in the height, width log(1 + |grad x - v| / width), does not; linearised at a first fused map
(reweighting: Candes, Wakin and Boyd 2008; Ochs et al. 2015, ref. [106] of the thesis, for depth) it is again TGV, with
a weight for every pixel. It is for the regulariser what the confidence (4.14) is for the data. The image of the
reference view, if wanted, gives weights from the first map on.
"""

from __future__ import annotations

import numpy as np

from ipcli.inverse.regularize.operators import gradient
from ipcli.models.fusion.parameters import Edges

BLUR = 0.7  # pixels, standard deviation: the noise of the image makes no edges


def first_order_weights(x: np.ndarray, v: np.ndarray, count: np.ndarray, edges: Edges) -> np.ndarray:
    """gain w / (w + |grad x - v|) (h, w) float32 of a first map x (h, w) with slopes v (2, h, w), in units of the
    noise.

    w is `edges.width` over the square root of the number of observations (h, w): what K of them leave of their noise.
    """
    jump = gradient(x) - v
    jump[0, :, -1] = jump[1, -1] = 0  # differences that do not exist
    width = edges.width / np.sqrt(np.maximum(count, 1))
    return (edges.gain * width / (width + np.hypot(*jump))).astype(np.float32)


def image_weights(image: np.ndarray, contrast: float) -> np.ndarray:
    """c / (c + |grad I|) (h, w) float32 of an image (h, w, 3) uint8; c is the change from a pixel to the next that
    halves the weight.

    Surfaces jump mostly where the image does: the scalar part of the image-driven tensor of Ranftl et al. (IV 2012) and
    Ferstl et al. (ICCV 2013), with the same concave shape as above. c is in grey levels of 255.
    """
    import cv2

    grey = cv2.GaussianBlur(cv2.cvtColor(image, cv2.COLOR_RGB2GRAY).astype(np.float32), (0, 0), BLUR)
    return (contrast / (contrast + np.hypot(*gradient(grey)))).astype(np.float32)
