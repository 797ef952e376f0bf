"""What brdf-train leaves for brdf-model: reflectance maps of materials under lights, the judge of rims, what materials
look like.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np

from ipcli.models.brdf.material import STATISTICS, Classifier
from ipcli.models.brdf.rim import FEATURES, Judge


@dataclass(frozen=True, eq=False)
class Library:
    """Maps, each of a material under a probe at a heading, and what was learnt on generated scenes."""

    charts: np.ndarray  # (j, s, s, 3) float32
    material: np.ndarray  # (j,) index into `materials`
    probe: np.ndarray  # (j,) index into `probes`
    materials: tuple[str, ...]
    probes: tuple[str, ...]
    judge: Judge
    classifier: Classifier

    @classmethod
    def of(cls, arrays: Mapping[str, np.ndarray]) -> Library:
        """From the arrays of a `brdf-library` artefact. ValueError for one that was learnt on other statistics of
        pictures than are taken now, or whose parts do not go together.
        """
        for key, known in (("rim_features", FEATURES), ("material_features", STATISTICS)):
            if arrays[key].tolist() != list(known):
                raise ValueError(f"{key} are not those of this version")
        spreads = np.concatenate([arrays["rim_spread"], arrays["material_spread"]])
        if not len(arrays["charts"]) or len(arrays["rim_weights"]) != 1 + 2 * len(FEATURES) or not (spreads > 0).all():
            raise ValueError("no maps, or weights that do not go with their statistics")
        judge = Judge(arrays["rim_weights"], arrays["rim_mean"], arrays["rim_spread"])
        materials, probes = (tuple(map(str, arrays[key])) for key in ("materials", "probes"))
        weights, bias, mean, spread = (arrays[f"material_{key}"] for key in ("weights", "bias", "mean", "spread"))
        classifier = Classifier(weights, bias, mean, spread, float(arrays["material_temperature"]))
        charts, material, probe = (arrays[key] for key in ("charts", "chart_material", "chart_probe"))
        return cls(charts, material, probe, materials, probes, judge, classifier)

    def arrays(self) -> dict[str, np.ndarray]:
        """The part of the artefact that `of` reads."""
        return {
            "charts": self.charts.astype(np.float32),
            "chart_material": self.material.astype(np.int64),
            "chart_probe": self.probe.astype(np.int64),
            "materials": np.array(self.materials),
            "probes": np.array(self.probes),
            "rim_features": np.array(FEATURES),
            "rim_weights": self.judge.weights,
            "rim_mean": self.judge.mean,
            "rim_spread": self.judge.spread,
            "material_features": np.array(STATISTICS),
            "material_weights": self.classifier.weights,
            "material_bias": self.classifier.bias,
            "material_mean": self.classifier.mean,
            "material_spread": self.classifier.spread,
            "material_temperature": np.array(self.classifier.temperature),
        }

    def grey(self) -> np.ndarray:
        """Mean of the channels of the charts (j, s, s), each over its own mean."""
        tables = self.charts.mean(axis=-1).astype(np.float64)
        return tables / np.maximum(tables.mean(axis=(1, 2), keepdims=True), 1e-12)
