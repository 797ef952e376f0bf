"""The artefacts of depth fusion (thesis chapter 4)."""

from __future__ import annotations

from ipcli.schema.fields import CAMERA, DISTANCE, FINITE, POSE, WEIGHT, Domain, Field, Kind, Ref

VIEWS = Kind(
    "views",
    1,
    "Depth maps with cameras, each of its own size. The items in order of their names, 2 before 10, are the sequence.",
    (
        Field("views/*/depth", "float32", ("h", "w"), "unit", "Depth along the optical axis", domain=DISTANCE),
        Field(
            "views/*/intrinsics", "float64", (3, 3), "px", "K; pixel centres at integers, as in OpenCV", domain=CAMERA
        ),
        Field("views/*/cam_from_world", "float64", (4, 4), "unit", "Rigid pose, dst_from_src", domain=POSE),
        Field("views/*/confidence", "float32", ("h", "w"), "1", "Weight of each depth", optional=True, domain=WEIGHT),
        Field("views/*/image", "uint8", ("h", "w", 3), "", "RGB", optional=True),
        Field("views/*/truth", "float32", ("h", "w"), "unit", "True depth", optional=True, domain=DISTANCE),
        Field("unit", "str", (), "", "Unit of length of the scene, such as `m`"),
        Field("measured", "str", (), "", "Quantity whose noise is homogeneous", choices=("depth", "disparity")),
        Field(
            "baseline_focal",
            "float64",
            (),
            "px*unit",
            "disparity = baseline_focal / depth",
            optional=True,
            domain=Domain("finite, > 0", 0.0, closed=False),
        ),
    ),
)

DEPTH = Kind(
    "fused-depth",
    1,
    "The fused depth map of one camera, with what is needed to judge it.",
    (
        Field("depth", "float32", ("h", "w"), "unit", "Fused depth along the optical axis", domain=DISTANCE),
        Field("confidence", "float32", ("h", "w"), "1", "Lambda of (4.3), relative to the noise scale", domain=WEIGHT),
        Field(
            "uncertainty",
            "float32",
            ("h", "w"),
            "unit",
            "Error to expect, up to a factor: orders pixels",
            True,
            DISTANCE,
        ),
        Field(
            "normals", "float32", ("h", "w", 3), "1", "Unit normals in the camera frame, facing the camera; NaN unknown"
        ),
        Field("observations", "uint16", ("h", "w"), "1", "Observations per pixel; 0: nothing was seen"),
        Field(
            "filled",
            "uint8",
            ("h", "w"),
            "",
            "How the depth came about: 0 from observations; 1 filled, none is there; 2 filled, none is near it",
            optional=True,
        ),
        Field(
            "mean",
            "float32",
            ("h", "w"),
            "unit",
            "Mean of the forward projected observations, a baseline",
            domain=DISTANCE,
        ),
        Field(
            "median",
            "float32",
            ("h", "w"),
            "unit",
            "Median of the forward projected observations, a baseline",
            domain=DISTANCE,
        ),
        Field("reference", "float32", ("h", "w"), "unit", "Depth of the reference view as given", domain=DISTANCE),
        Field("intrinsics", "float64", (3, 3), "px", "K; pixel centres at integers, as in OpenCV", domain=CAMERA),
        Field("cam_from_world", "float64", (4, 4), "unit", "Rigid pose, dst_from_src", domain=POSE),
        Field("image", "uint8", ("h", "w", 3), "", "RGB of the reference view", optional=True),
        Field("truth", "float32", ("h", "w"), "unit", "True depth", optional=True, domain=DISTANCE),
        Field(
            "noise_scale",
            "float64",
            (),
            "unit, px or 1/unit",
            "Robust scale of the noise, in the domain",
            domain=WEIGHT,
        ),
        Field("views", "str", ("k",), "", "Names of the fused views"),
        Field("view_valid", "float64", ("k",), "1", "Share of the view's pixels that hold data"),
        Field("view_overlap", "float64", ("k",), "1", "Share of the reference pixels that the view hits"),
        Field("view_residual", "float64", ("k",), "unit", "Median of abs(d_k - fused); NaN without overlap"),
        Field("thumbnails", "float32", ("k", "th", "tw"), "unit", "Observations of each view, made small; NaN none"),
        Field(
            "history",
            "float64",
            ("n", 5),
            "1",
            "Columns: ACS round, iteration, energy, restricted gap (relative), merit",
        ),
        Field("unit", "str", (), "", "Unit of length of the scene, such as `m`"),
        Field(
            "domain", "str", (), "", "Quantity that was regularised", choices=("depth", "disparity", "inverse depth")
        ),
        Field("method", "str", (), "", "Algorithm and regulariser"),
        Field("lambda", "float64", (), "1", "Weight of the data", domain=WEIGHT),
        Field("fused_into", "str", (), "", "Name of the view or camera that was fused into", optional=True),
        Field("warnings", "str", ("q",), "", "What is odd about the views or the fusion", optional=True),
        Field("tile", "int64", (), "px", "Side of the tiles in which it was fused; left out: at once", optional=True),
        Field("metrics", "float64", ("m", "c"), "", "Error measures against `truth`; NaN undefined", optional=True),
        Field("metric_rows", "str", ("m",), "", "Result that each row measures", optional=True),
        Field("metric_columns", "str", ("c",), "", "Measure and unit of each column", optional=True),
        Field(
            "ause",
            "float64",
            (),
            "1",
            "Area under the sparsification error of `confidence`, in mean errors",
            optional=True,
        ),
        Field("ause_uncertainty", "float64", (), "1", "The same of `uncertainty`", optional=True),
        Field("ause_angle", "float64", (), "1", "The same of the angle of view (4.35) as a confidence", optional=True),
    ),
    together=(("metrics", "metric_rows", "metric_columns"),),
)

COMPARISON = Kind(
    "fusion-comparison",
    1,
    "Error measures of several methods on several scenes.",
    (
        Field("scenes", "str", ("s",), "", "Name of each scene"),
        Field("methods", "str", ("m",), "", "Name of each method"),
        Field("columns", "str", ("c",), "", "Measure and unit of each column"),
        Field("values", "float64", ("s", "m", "c"), "", "Measures; NaN undefined, or not run"),
    ),
)

TUNING = Kind(
    "fusion-tuning",
    1,
    "Errors of several methods over a grid of lambda, on scenes of known truth.",
    (
        Field("scenes", "str", ("s",), "", "Name of each scene"),
        Field("methods", "str", ("m",), "", "Name of each method"),
        Field("lambdas", "float64", ("n",), "1", "Weights of the data that were tried, in order", domain=WEIGHT),
        Field("columns", "str", ("c",), "", "Measure and unit of each column"),
        Field("values", "float64", ("s", "m", "n", "c"), "", "Measures; NaN undefined"),
        Field("automatic_lambda", "float64", ("s", "m"), "1", "Weight that is taken if none is given", domain=WEIGHT),
        Field("automatic", "float64", ("s", "m", "c"), "", "Measures at that weight"),
        Field("measure", "str", (), "", "Column whose mean over the scenes `best` makes least", refers=Ref("columns")),
        Field("best", "float64", ("m",), "1", "Best of `lambdas` for each method", domain=WEIGHT),
    ),
)

TRIALS = Kind(
    "fusion-trials",
    1,
    "Error measures of several methods on one scene of known truth, each at one or two lambdas, and some of the maps.",
    (
        Field("methods", "str", ("m",), "", "Name of the method of each row"),
        Field("rules", "str", ("m",), "", "Where its lambda is from", choices=("none", "automatic", "tuned")),
        Field(
            "lambdas",
            "float64",
            ("m",),
            "1",
            "Weight of the data; NaN without",
            domain=Domain(">= 0, or NaN", 0.0, nan=True),
        ),
        Field("columns", "str", ("c",), "", "Measure and unit of each column"),
        Field("values", "float64", ("m", "c"), "", "Measures; NaN undefined"),
        Field(
            "kept_error",
            "float64",
            ("m", "k"),
            "mean error",
            "Mean error of the k/K most confident pixels; NaN without confidence",
        ),
        Field(
            "kept_error_uncertainty",
            "float64",
            ("m", "k"),
            "mean error",
            "The same by `uncertainty` of fuse-depth",
            optional=True,
        ),
        Field(
            "kept_error_angle",
            "float64",
            ("m", "k"),
            "mean error",
            "The same by the angle of view (4.35)",
            optional=True,
        ),
        Field("least_error", "float64", ("m", "k"), "mean error", "The same of the pixels that err least"),
        Field("maps", "str", ("n",), "", "Method of each map kept, at the automatic lambda", refers=Ref("methods")),
        Field(
            "depth", "float32", ("n", "h", "w"), "unit", "Fused depth; NaN where nothing was observed", domain=DISTANCE
        ),
        Field(
            "confidence",
            "float32",
            ("n", "h", "w"),
            "1",
            "Lambda of (4.3), relative to the noise scale; 0 without",
            domain=WEIGHT,
        ),
        Field("truth", "float32", ("h", "w"), "unit", "True depth", domain=DISTANCE),
        Field("intrinsics", "float64", (3, 3), "px", "K; pixel centres at integers, as in OpenCV", domain=CAMERA),
        Field("unit", "str", (), "", "Unit of length of the scene, such as `m`"),
    ),
)

CLOUD = Kind(
    "fusion-cloud",
    1,
    "One cloud of points from several fused maps, in world coordinates.",
    (
        Field("points", "float32", ("n", 3), "unit", "Mean of what the maps saw", domain=FINITE),
        Field("normals", "float32", ("n", 3), "1", "Unit length, facing the cameras", domain=FINITE),
        Field("colors", "uint8", ("n", 3), "", "RGB", optional=True),
        Field("confidence", "float32", ("n",), "1", "Sum of the confidences of the maps that agree", domain=WEIGHT),
        Field("views", "uint16", ("n",), "1", "Maps that agree on the point"),
        Field("spacing", "float64", (), "unit", "Side of the cells within which points were merged", domain=WEIGHT),
        Field("maps", "str", ("m",), "", "File of each fused map"),
        Field("cam_from_world", "float64", ("m", 4, 4), "unit", "Rigid pose of each map, dst_from_src", domain=POSE),
        Field("map_points", "int64", ("m",), "1", "Points of the map: pixels that were observed"),
        Field("map_confirmed", "int64", ("m",), "1", "Those confirmed by enough other maps"),
        Field("map_contradicted", "int64", ("m",), "1", "Those that more maps look through than confirm"),
        Field("unit", "str", (), "", "Unit of length of the scene, such as `m`"),
        Field("warnings", "str", ("q",), "", "What is odd about the maps", optional=True),
    ),
)

KINDS = (VIEWS, DEPTH, COMPARISON, TUNING, TRIALS, CLOUD)
