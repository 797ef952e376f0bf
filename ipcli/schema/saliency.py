"""The kinds of saliency (thesis 3.3 to 3.5)."""

from ipcli.schema.fields import FINITE, WEIGHT, Domain, Field, Kind

SPREAD = Domain("> 0", 0.0, closed=False)
MEASURED = Domain("finite, or NaN where undefined", nan=True)
KNOWN = Domain("finite, or NaN where unknown", nan=True)
COUNT = Domain(">= 0", 0.0)
SHARE = Domain(">= 0, or NaN where unknown", 0.0, nan=True)

MODEL = (
    Field("model/columns", "int64", ("d",), "1", "Columns of the table of features that it takes", True, COUNT),
    Field("model/centre", "float64", ("d",), "", "Subtracted from each", True, FINITE),
    Field("model/scale", "float64", ("d",), "", "Divides each", True, FINITE),
    Field("model/supports", "float64", ("sv", "d"), "1", "Scaled points that its kernels sit on", True, FINITE),
    Field("model/weights", "float64", ("sw",), "1", "Of the kernels; of the columns where gamma is 0", True, FINITE),
    Field("model/gamma", "float64", (), "1", "exp(-gamma |x - s|^2); 0: linear", True, WEIGHT),
    Field("model/offset", "float64", (), "1", "rho of (3.19)", True, FINITE),
    Field("model/slope", "float64", (2,), "1", "Saliency is 1 / (1 + exp(-(slope f + intercept)))", True, FINITE),
    Field("model/threshold", "float64", (), "1", "5 % of points nobody looked at have a greater f", True, FINITE),
    Field("model/domain", "float64", (2, 3), "m", "Task domain of (F3), from where the search began", True, FINITE),
)

SALIENCY = Kind(
    "saliency",
    1,
    "Saliency of the points of a scene, its maps in pictures, proto-objects and what was learnt (thesis 3.3 to 3.5).",
    (
        Field("subsequences/frames", "int64", ("s", 2), "1", "First frame and the one after the last", domain=COUNT),
        Field("subsequences/times", "float64", ("s", 2), "s", "Time of the first and of the last", domain=FINITE),
        Field("subsequences/regards", "int64", ("s",), "1", "Points of regard in each", domain=COUNT),
        Field("subsequences/nodes", "int64", ("s",), "1", "Nodes of its surface", domain=COUNT),
        Field("subsequences/error", "float64", ("s",), "m", "Residual of the surface, inner 90 %", domain=FINITE),
        Field(
            "subsequences/attended",
            "float64",
            ("s", 2),
            "1",
            "Share of nodes in its coherent regions, and in any",
            domain=WEIGHT,
        ),
        Field("subsequences/ranking", "float64", ("s", "b"), "1", "Area under the curve of each score", domain=KNOWN),
        Field("rankings", "str", ("b",), "", "Names of these scores"),
        Field("points/places", "float32", ("p", 3), "m", "Points of the surfaces in the world", domain=FINITE),
        Field(
            "points/saliency", "float32", ("p",), "1", "Learnt, or rank of the energy where nothing is", domain=FINITE
        ),
        Field("points/energy", "float32", ("p",), "1", "Energy of the membrane", domain=WEIGHT),
        Field(
            "points/attended", "float32", ("p",), "1", "Share of subsequences in which it was looked at", domain=WEIGHT
        ),
        Field("points/curvature", "float32", ("p",), "1/m", "sqrt |K_G| of the surface", domain=WEIGHT),
        Field("pictures/frames", "int64", ("t",), "1", "Frame of each picture kept", domain=COUNT),
        Field("pictures/subsequence", "int64", ("t",), "1", "Its subsequence", domain=COUNT),
        Field("pictures/images", "uint8", ("t", "h", "w", 3), "", "The pictures"),
        Field(
            "pictures/maps",
            "float32",
            ("t", "y", "x"),
            "1",
            "Saliency, a cell to 4 pixels; NaN no surface",
            domain=KNOWN,
        ),
        Field("regards/picture", "int64", ("r",), "1", "Picture of each point of regard shown", domain=COUNT),
        Field("regards/pixels", "float64", ("r", 2), "px", "Where it is in the picture", domain=FINITE),
        Field("objects/places", "float64", ("o", 3), "m", "Middle of each proto-object in the world", domain=FINITE),
        Field("objects/subsequence", "int64", ("o",), "1", "Its subsequence", domain=COUNT),
        Field("objects/times", "float64", ("o", 2), "s", "From when to when", domain=FINITE),
        Field("objects/energy", "float64", ("o",), "1", "Energy at its middle", domain=WEIGHT),
        Field("objects/saliency", "float64", ("o",), "1", "Mean saliency of its patch", domain=FINITE),
        Field(
            "objects/hit",
            "int64",
            ("o",),
            "1",
            "2: looked at in its subsequence, 1: at another time, 0: never, -1: no gaze",
        ),
        Field("objects/track", "int64", ("o",), "1", "Proto-objects of one place share a track", domain=COUNT),
        Field("outlines/object", "int64", ("l",), "1", "Proto-object of each point of an outline", domain=COUNT),
        Field("outlines/picture", "int64", ("l",), "1", "Picture it is in", domain=COUNT),
        Field("outlines/pixels", "float64", ("l", 2), "px", "Where, in order along the rim", domain=FINITE),
        Field(
            "hits",
            "float64",
            (2, 2),
            "1",
            "In coherent regions of the subsequence, of any: share of proto-objects, of nodes",
            domain=SHARE,
        ),
        Field("extents", "float64", ("e", 2), "1", "Subsequence and share of a picture that is attended", domain=SHARE),
        Field("radius", "float64", (), "m", "Of a coherent region and of a proto-object", domain=WEIGHT),
        Field(
            "folds/rates", "float64", ("f", 5), "1", "Positives, misses, alarms, accuracy, (3.35) by fold", True, KNOWN
        ),
        Field("groups/names", "str", ("g",), "", "Groups of features taken together", True),
        Field("groups/balanced", "float64", ("g",), "1", "Their balanced error rate (3.35)", True, KNOWN),
        Field("elimination/names", "str", ("i",), "", "Groups left by elimination, from all to one", True),
        Field("elimination/balanced", "float64", ("i",), "1", "Their balanced error rate", True, KNOWN),
        Field("membranes/parameters", "float64", ("q", 3), "1", "sigma, z and radius of the strongest", True, FINITE),
        Field("membranes/times", "float64", ("j",), "s", "Moments at which they are shown", True, FINITE),
        Field(
            "membranes/shapes", "float32", ("q", "j", "ma", "mb"), "1", "Displacement by radius, angle", True, FINITE
        ),
        *MODEL,
        Field("notes", "str", ("n",), "", "What was left out or is doubtful, and why"),
        Field("source", "str", (), "", "Kind of recording"),
    ),
    together=(
        ("groups/names", "groups/balanced", "elimination/names", "elimination/balanced", "folds/rates"),
        ("membranes/parameters", "membranes/times", "membranes/shapes"),
        tuple(field.name for field in MODEL),
    ),
)

PREDICTOR = Kind(
    "saliency-model",
    1,
    "What tells the places that are looked at from the rest, learnt from recorded fixations: logistic regression of "
    "named features, and boosted trees.",
    (
        Field("subject", "str", (), "", "What it is for", choices=("pictures", "surfaces")),
        Field("features", "str", ("k",), "", "Names of the features"),
        Field("mean", "float64", ("k",), "", "Mean of each feature", domain=FINITE),
        Field("spread", "float64", ("k",), "", "Standard deviation of each", domain=SPREAD),
        Field("weights", "float64", ("k",), "1", "Of the standardised features in the log odds", domain=FINITE),
        Field("bias", "float64", (), "1", "Constant of the log odds", domain=FINITE),
        Field("trees/feature", "int64", ("t", "m"), "1", "Feature that each node asks for", optional=True),
        Field("trees/threshold", "float64", ("t", "m"), "", "Values up to it go left", optional=True, domain=FINITE),
        Field("trees/left", "int64", ("t", "m"), "1", "Node to the left; -1: a leaf", optional=True),
        Field("trees/right", "int64", ("t", "m"), "1", "Node to the right; -1: a leaf", optional=True),
        Field("trees/value", "float64", ("t", "m"), "1", "Log odds that a leaf adds", optional=True, domain=FINITE),
        Field("trees/start", "float64", (), "1", "Log odds before any tree", optional=True, domain=FINITE),
        Field("items", "str", ("i",), "", "Pictures or surfaces that it was learnt from"),
        Field("fixations", "int64", (), "1", "Fixations in them, or vertices that were looked at", domain=WEIGHT),
    ),
    together=(tuple(f"trees/{name}" for name in ("feature", "threshold", "left", "right", "value", "start")),),
)

MAPS = Kind(
    "saliency-maps",
    1,
    "How likely each place of pictures or surfaces is looked at, by chance 1.",
    (
        Field("model", "str", (), "", "What predicted it"),
        Field("pictures/*/picture", "uint8", ("h", "w", 3), "", "RGB, as given or shrunk", optional=True),
        Field("pictures/*/map", "float32", ("a", "b"), "1", "On a grid over the picture", optional=True, domain=WEIGHT),
        Field("surfaces/*/points", "float32", ("n", 3), "unit", "Vertices or points", optional=True, domain=FINITE),
        Field("surfaces/*/normals", "float32", ("n", 3), "1", "Unit normals", optional=True, domain=FINITE),
        Field("surfaces/*/map", "float32", ("n",), "1", "Of each point", optional=True, domain=WEIGHT),
    ),
    together=(
        ("pictures/*/picture", "pictures/*/map"),
        ("surfaces/*/points", "surfaces/*/map"),
    ),
    needs=(("surfaces/*/normals", "surfaces/*/points"),),
)

EVALUATION = Kind(
    "saliency-evaluation",
    1,
    "How well models, single features and baselines predict recorded fixations.",
    (
        Field("subject", "str", (), "", "What was predicted on", choices=("pictures", "surfaces")),
        Field("protocol", "str", (), "", "How learnt models were kept from what they are judged by"),
        Field("predictors", "str", ("r",), "", "Names of models, features and baselines"),
        Field("roles", "str", ("r",), "", "What each is", choices=("model", "baseline", "ceiling", "feature")),
        Field("measures", "str", ("c",), "", "Names of the measures"),
        Field("values", "float64", ("r", "c"), "", "AUC, sAUC, NSS, IG: mean over fixations", domain=MEASURED),
        Field("items", "str", ("i",), "", "Names of the pictures or surfaces"),
        Field("each", "float64", ("r", "i", "c"), "", "Mean of each item", domain=MEASURED),
        Field("looked_at", "int64", ("i",), "1", "Fixations, or vertices that were looked at, of each", domain=WEIGHT),
        Field("default", "str", (), "", "The predictor that is shown"),
        Field("notes", "str", ("q",), "", "What a reader should know before believing it"),
        Field("shown/*/picture", "uint8", ("h", "w", 3), "", "RGB, shrunk", optional=True),
        Field("shown/*/fixations", "float32", ("f", 2), "1", "x, y as shares of the picture", True, FINITE),
        Field("shown/*/points", "float32", ("n", 3), "unit", "Vertices", optional=True, domain=FINITE),
        Field("shown/*/normals", "float32", ("n", 3), "1", "Unit normals", optional=True, domain=FINITE),
        Field("shown/*/truth", "float32", ("n",), "1", "How long vertices were looked at, smoothed", True, WEIGHT),
        Field("shown/*/predictors", "str", ("s",), "", "Predictors whose maps are kept", optional=True),
        Field("shown/*/maps", "float32", ("s", "a", "b"), "1", "Their maps; b = 1 on surfaces", True, MEASURED),
    ),
    together=(("shown/*/predictors", "shown/*/maps"),),
    needs=(
        ("shown/*/fixations", "shown/*/picture"),
        ("shown/*/normals", "shown/*/points"),
        ("shown/*/truth", "shown/*/points"),
    ),
)

KINDS: tuple[Kind, ...] = (SALIENCY, PREDICTOR, MAPS, EVALUATION)
