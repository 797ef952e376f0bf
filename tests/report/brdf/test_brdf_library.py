"""The page of a library names its materials and how often the judge is right."""

import numpy as np

from ipcli.report.brdf import brdf_library


def test_every_material_has_its_balls():
    arrays = {
        "charts": np.random.default_rng(0).uniform(size=(4, 9, 9, 3)).astype(np.float32),
        "chart_material": np.array([0, 0, 1, 1]),
        "chart_probe": np.array([0, 1, 0, 1]),
        "chart_heading": np.zeros(4),
        "materials": np.array(["brass", "<red>"]),
        "is_metal": np.array([1, 0], np.uint8),
        "probes": np.array(["p", "q"]),
        "material_accuracy": np.array([0.8, 0.9]),
        "rim_accuracy": np.array(0.75),
        "rim_scenes": np.array(40),
        "rim_features": np.array(["a"]),
        "rim_weights": np.array([0.1, 0.2, 0.3]),
        "rim_mean": np.array([1.0]),
        "rim_spread": np.array([1.0]),
    }
    text = brdf_library.page(arrays, {})
    assert text.count("<img") == 4
    assert "&lt;red&gt;" in text
    assert "75" in text
