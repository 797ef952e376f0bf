"""The kinds of saliency (thesis 3.3 to 3.5)."""

from ipcli.schema.fields import FINITE, WEIGHT, Domain, Field, Kind

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
)

KINDS: tuple[Kind, ...] = (SALIENCY,)
