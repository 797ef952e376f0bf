"""The kinds of chapter 7: a library of materials, and an object modelled from one picture."""

from __future__ import annotations

from ipcli.schema.fields import FINITE, WEIGHT, Domain, Field, Kind, Ref

LIBRARY = Kind(
    "brdf-library",
    1,
    "Reflectance maps of materials under light probes, and what was learnt on generated scenes. Frame: x right, "
    "y up, z to the viewer.",
    (
        Field(
            "charts",
            "float32",
            ("j", "s", "s", 3),
            "1",
            "R(n): entry [i, k] at n_x = -1 + 2 i / (s - 1), n_y likewise",
            domain=WEIGHT,
        ),
        Field("chart_material", "int64", ("j",), "1", "Material of each map", refers=Ref("materials")),
        Field("chart_probe", "int64", ("j",), "1", "Probe of each map", refers=Ref("probes")),
        Field("chart_heading", "float64", ("j",), "rad", "Turn of the probe about the vertical", domain=FINITE),
        Field("materials", "str", ("b",), "", "Names of the materials"),
        Field("is_metal", "uint8", ("b",), "1", "1: conductor"),
        Field("probes", "str", ("p",), "", "Names of the light probes"),
        Field("rim_features", "str", ("f",), "", "What the judge of rims looks at"),
        Field(
            "rim_weights",
            "float64",
            ("g",),
            "1",
            "Logistic regression: constant, features, their squares less 1",
            domain=FINITE,
        ),
        Field("rim_mean", "float64", ("f",), "1", "Mean of each feature", domain=FINITE),
        Field("rim_spread", "float64", ("f",), "1", "Standard deviation of each feature", domain=FINITE),
        Field("material_features", "str", ("m",), "", "Statistics of a picture that tell its material"),
        Field(
            "material_weights",
            "float64",
            ("m", "b"),
            "1",
            "Linear discriminants of the standardised statistics",
            domain=FINITE,
        ),
        Field("material_bias", "float64", ("b",), "1", "Their constants", domain=FINITE),
        Field("material_mean", "float64", ("m",), "1", "Mean of each statistic", domain=FINITE),
        Field("material_spread", "float64", ("m",), "1", "Standard deviation of each statistic", domain=FINITE),
        Field(
            "material_temperature", "float64", (), "1", "Factor of the scores, from held-out pictures", domain=WEIGHT
        ),
        Field(
            "material_accuracy",
            "float64",
            (2,),
            "1",
            "Shares of pictures of held-out surfaces under held-out probes: material right, metal or not right",
        ),
        Field("rim_accuracy", "float64", (), "1", "Share of right answers on held-out generated scenes"),
        Field("rim_scenes", "int64", (), "1", "Generated scenes it was learnt from"),
    ),
)

OBJECT = Kind(
    "brdf-object",
    1,
    "The surface of an object from one picture, orthographic. Heights and normals: x right, y UP, z to the "
    "viewer; rows run down.",
    (
        Field("picture", "uint8", ("h", "w", 3), "", "RGB as given, for the eye"),
        Field("mask", "uint8", ("h", "w"), "1", "1: object"),
        Field("height", "float32", ("h", "w"), "px", "Height towards the viewer, mean 0; NaN outside"),
        Field("normals", "float32", ("h", "w", 3), "1", "Unit normals; NaN outside"),
        Field("confidence", "float32", ("h", "w"), "1", "Agreement of the explanations, 1 when one; NaN outside"),
        Field("initial_height", "float32", ("h", "w"), "px", "Shape it set out from; NaN outside"),
        Field("shading", "float32", ("h", "w"), "1", "Picture as the map and the surface explain it; NaN outside"),
        Field("intensity", "float32", ("h", "w"), "1", "Grey linear picture over its 95th percentile; NaN outside"),
        Field("reflectance", "float32", ("s", "s"), "1", "R(n) that was found, laid out as in `brdf-library`"),
        Field(
            "sheet", "float64", (), "1", "Probability that the silhouette is a cut edge, as it was used", domain=WEIGHT
        ),
        Field("rim_features", "str", ("f",), "", "What the judge of rims looked at"),
        Field("rim_values", "float64", ("f",), "1", "What it saw"),
        Field("solid_height", "float32", ("h", "w"), "px", "Surface if it were a solid", optional=True),
        Field("sheet_height", "float32", ("h", "w"), "px", "Surface if it were a sheet", optional=True),
        Field("residual", "float64", (), "1", "Mean difference of `shading` and picture on the grid of inference"),
        Field(
            "tie",
            "float64",
            (),
            "1",
            "Energy of the other relief less that of this one, over their mean; NaN: not compared",
        ),
        Field("light_above", "uint8", (), "1", "1: the light that was found comes from above"),
        Field(
            "saturated",
            "float64",
            (),
            "1",
            "Share of the object's pixels at the top of the camera's range",
            domain=WEIGHT,
        ),
        Field("pixel_size", "float64", (), "unit", "Side of a pixel", domain=Domain("finite, > 0", 0.0, closed=False)),
        Field("unit", "str", (), "", "Unit of length: `px` or `mm`"),
        Field("materials", "str", ("b",), "", "Materials of the library"),
        Field("material_posterior", "float64", ("b",), "1", "Probability of each", domain=WEIGHT),
        Field("probes", "str", ("p",), "", "Light probes of the library"),
        Field("probe_posterior", "float64", ("p",), "1", "Probability of each; NaN where no maps were compared"),
        Field("truth_normals", "float32", ("h", "w", 3), "1", "True normals, NaN unknown", optional=True),
        Field("truth_height", "float32", ("h", "w"), "px", "True height, NaN unknown", optional=True),
        Field("metrics", "float64", ("m", "c"), "", "Errors against the truth; NaN undefined", optional=True),
        Field("metric_rows", "str", ("m",), "", "Surface that each row measures", optional=True),
        Field("metric_columns", "str", ("c",), "", "Measure and unit of each column", optional=True),
    ),
    together=(("metrics", "metric_rows", "metric_columns"),),
)

KINDS = (LIBRARY, OBJECT)
