"""How well a map predicts fixations: AUC, shuffled AUC, NSS, information gain; CC, SIM and KL between maps.

Definitions are those of pysaliency (Kuemmerer et al.), which the field's benchmark uses: an AUC counts ties by half and
averages over fixations, AUC-Judd takes all pixels as negatives and the shuffled one the fixations on other pictures.
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from ipcli.errors import ParameterError

TINY = 2.2204e-16  # the benchmark's regularisation of KL
MOST_COUNT = 64  # fixations in one pixel, beyond which numbers in a map are no counts


def fixations_of(given: np.ndarray) -> np.ndarray:
    """Pixels (n, 2) as (x, y) of fixations that come as such rows or as a map (h, w) of counts.

    Raises ParameterError for a blurred map: what was blurred has no points to be found in it, and figures on it are
    not comparable.
    """
    given = np.asarray(given)
    if given.ndim == 2 and given.shape[1] == 2:
        return np.floor(given).astype(np.int64)
    if given.ndim != 2:
        raise ParameterError(f"fixations: expected rows of (x, y) or a map (h, w), got shape {given.shape}")
    counts = np.rint(np.asarray(given, np.float64))
    is_mask = np.unique(given).size <= 2
    is_count = np.array_equal(counts, given) and given.min(initial=0) >= 0 and given.max(initial=0) <= MOST_COUNT
    if not (is_mask or is_count):
        raise ParameterError(
            "fixations: this is a blurred map, and fixations are asked for. Give their points; CC, SIM and KL alone "
            "are defined on blurred maps"
        )
    present = given > 0
    times = counts[present] if is_count else np.ones(int(present.sum()))
    rows, columns = np.nonzero(present)
    return np.repeat(np.stack([columns, rows], axis=1), times.astype(np.int64), axis=0)


def values_at(saliency: np.ndarray, fixations: np.ndarray) -> np.ndarray:
    """Values (n,) of a map (h, w) in pixels (n, 2) as (x, y); ParameterError for one outside."""
    points = fixations_of(fixations)
    if len(points) and ((points < 0).any() or (points >= saliency.shape[::-1]).any()):
        raise ParameterError(f"fixations: outside the map of {saliency.shape[1]} x {saliency.shape[0]} pixels")
    return saliency[points[:, 1], points[:, 0]].astype(np.float64)


def auc_each(positives: np.ndarray, negatives: np.ndarray) -> np.ndarray:
    """Share (n,) of the negatives (m,) that lie below each positive, equal ones by half: its area under the ROC."""
    ordered = np.sort(negatives)
    below = np.searchsorted(ordered, positives, "left")
    upto = np.searchsorted(ordered, positives, "right")
    return (below + upto) / (2 * max(len(ordered), 1))


def auc(saliency: np.ndarray, fixations: np.ndarray) -> np.ndarray:
    """AUC-Judd (n,) of each fixation: all pixels of the map are negatives."""
    return auc_each(values_at(saliency, fixations), np.asarray(saliency, np.float64).ravel())


def shuffled_auc(saliency: np.ndarray, fixations: np.ndarray, elsewhere: np.ndarray) -> np.ndarray:
    """Shuffled AUC (n,) of each fixation: fixations (m, 2) on other pictures, at this one's size, are negatives.

    One and the same map for every picture, such as a centre prior, gets exactly .5 where pictures have equally many
    fixations, since each pair of fixations is counted both ways.
    """
    return auc_each(values_at(saliency, fixations), values_at(saliency, elsewhere))


def nss(saliency: np.ndarray, fixations: np.ndarray) -> np.ndarray:
    """Normalised scanpath saliency (n,): the standardised map at each fixation; 0 for a constant map."""
    saliency = np.asarray(saliency, np.float64)
    spread = saliency.std()
    return (values_at(saliency, fixations) - saliency.mean()) / (spread if spread > 0 else 1.0)


def density(saliency: np.ndarray, least: float = 0.0) -> np.ndarray:
    """A map as a probability of each pixel: lifted to be >= 0, `least` added, divided by its sum."""
    saliency = np.asarray(saliency, np.float64)
    lifted = saliency - min(float(saliency.min()), 0.0) + least
    total = lifted.sum()
    return lifted / total if total > 0 else np.full(lifted.shape, 1 / lifted.size)


def correlation(saliency: np.ndarray, truth: np.ndarray) -> float:
    """CC: Pearson's correlation of two maps (h, w); 0 if one is constant."""
    a, b = (np.asarray(part, np.float64) - np.mean(part) for part in (saliency, truth))
    size = float(np.sqrt((a * a).sum() * (b * b).sum()))
    return float((a * b).sum()) / size if size > 0 else 0.0


def similarity(saliency: np.ndarray, truth: np.ndarray) -> float:
    """SIM: the mass that the two maps share as densities, 1 for equal ones."""
    return float(np.minimum(density(saliency), density(truth)).sum())


def divergence(saliency: np.ndarray, truth: np.ndarray) -> float:
    """KL: divergence in nats of the truth's density from the map's, regularised as the benchmark does."""
    p, q = density(truth), density(saliency)
    return float((p * np.log(TINY + p / (q + TINY))).sum())


def information_gain(saliency: np.ndarray, fixations: np.ndarray, baseline: np.ndarray) -> np.ndarray:
    """Bits (n,) by which each fixation is likelier under the map's density than under the baseline's (h, w)."""
    with np.errstate(divide="ignore"):
        ours, theirs = (np.log2(values_at(density(part, TINY), fixations)) for part in (saliency, baseline))
    return ours - theirs


def fixation_map(fixations: np.ndarray, shape: tuple[int, int], sigma: float) -> np.ndarray:
    """Density (h, w) of fixations blurred by a Gaussian of `sigma` pixels, the "empirical map" of CC, SIM and KL."""
    from scipy.ndimage import gaussian_filter

    points = fixations_of(fixations)
    counts = np.zeros(shape)
    np.add.at(counts, (points[:, 1], points[:, 0]), 1.0)
    return density(gaussian_filter(counts, sigma, mode="constant", truncate=4.0))


def rescaled(fixations: np.ndarray, size: tuple[int, int], shape: tuple[int, int]) -> np.ndarray:
    """Fixations (n, 2) in pixels of a picture of `size` (h, w) as pixels (n, 2) of a map of `shape`, kept inside."""
    scale = np.array(shape[::-1]) / np.array(size[::-1])
    inside = np.floor(np.asarray(fixations, np.float64) * scale).astype(np.int64)
    return np.clip(inside, 0, np.array(shape[::-1]) - 1)


def others(all_fixations: Sequence[np.ndarray], index: int) -> np.ndarray:
    """Fixations (m, 2) on every picture but one, each set already at the size of that one."""
    rest = [points for k, points in enumerate(all_fixations) if k != index]
    return np.concatenate(rest) if rest else np.zeros((0, 2), np.int64)
