"""The kinds of the mocap commands (thesis chapter 5)."""

from dataclasses import replace

from ipcli.schema.fields import FINITE, WEIGHT, Domain, Field, Kind, Ref

CLIPS = Kind(
    "clips",
    1,
    "Labelled clips of motion of one skeleton, their frames one clip after the other. World: right-handed, y up.",
    (
        Field("clips", "str", ("c",), "", "Name of each clip"),
        Field("labels", "str", ("c",), "", "Action of each clip; empty where unknown"),
        Field("actors", "str", ("c",), "", "Who moves; empty where unknown"),
        Field("frames", "int64", ("c",), "1", "Frames of each clip; they add up to n", domain=Domain(">= 1", 1.0)),
        Field(
            "rates",
            "float64",
            ("c",),
            "Hz",
            "Frames a second of each clip",
            domain=Domain("finite, > 0", 0.0, closed=False),
        ),
        Field("joints", "str", ("j",), "", "Name of each joint"),
        Field(
            "parents",
            "int64",
            ("j",),
            "1",
            "Index of the parent of each joint; -1 none",
            domain=Domain(">= -1", -1.0),
            refers=Ref("joints", none=True),
        ),
        Field(
            "positions",
            "float32",
            ("n", "j", 3),
            "m",
            "Joints in the world",
            domain=Domain("finite, or NaN where not seen", nan=True),
        ),
        Field(
            "rotations",
            "float32",
            ("n", "j", 4),
            "1",
            "Quaternion x, y, z, w of world_from_bone; NaN unknown",
            optional=True,
        ),
        Field("frame_labels", "str", ("n",), "", "Action in each frame; empty where unknown", optional=True),
        Field("split_names", "str", ("s",), "", "Published splits of the data set", optional=True),
        Field("splits", "int8", ("s", "c"), "1", "1: clip to train on, 2: to test on, 0: neither", optional=True),
        Field("notes", "str", ("o",), "", "What is odd about the files they were read from", optional=True),
    ),
    together=(("split_names", "splits"),),
)


HELD_OUT = ("held_out_", "held_out_pose_")


def _held_out(prefix: str, many: str, what: str) -> tuple[Field, ...]:
    """What the models of the folds say of clips held out of them, which "none of these" is calibrated on."""
    of = f"of {what} to the model of its fold"
    told: tuple[tuple[str, tuple[int | str, ...], str], ...] = (
        ("log_posterior", (many, "a"), f"Mean log posterior of frames {of}"),
        ("density", (many, "a", "g"), f"Mean log density a dimension {of}; NaN not seen"),
        ("evidence", (many, "a", "g"), f"Mean log posterior by each group {of}; NaN not seen"),
        ("course", (many, 3, "a", "g"), f"The same of each third {of}; NaN not seen, or not in order"),
        (
            "scores",
            (many, 6),
            f"Novelty scores {of}: density, groups, actions, motion, course of motion and of the body; NaN not told",
        ),
    )
    return (
        Field(f"{prefix}action", "int64", (many,), "1", f"Action of {what}", optional=True, refers=Ref("actions")),
        Field(
            f"{prefix}fold",
            "int64",
            (many,),
            "1",
            f"Fold that {what} was held out of",
            optional=True,
            refers=Ref("fold_alpha"),
        ),
        *(Field(f"{prefix}{name}", "float64", dims, "1", doc, optional=True) for name, dims, doc in told),
    )


FOLDS = (
    Field("fold_alpha", "float64", ("f", "a", "g"), "1", "As `alpha`, of a model without a part of the people"),
    Field("fold_dimensions", "int64", ("f", "g"), "1", "As `dimensions`"),
    Field("fold_shift", "float64", ("f", "g", "x"), "", "As `shift`", domain=FINITE),
    Field("fold_matrix", "float64", ("f", "g", "x", "e"), "", "As `matrix`", domain=FINITE),
    Field("fold_component_model", "int64", ("h",), "1", "Fold of each component", refers=Ref("fold_alpha")),
    Field("fold_component_action", "int64", ("h",), "1", "Its action", refers=Ref("actions")),
    Field("fold_component_group", "int64", ("h",), "1", "Its group", refers=Ref("groups")),
    Field("fold_log_weight", "float64", ("h",), "1", "log weight within fold, action and group"),
    Field("fold_dof", "float64", ("h",), "1", "Degrees of freedom of its t density", domain=WEIGHT),
    Field("fold_location", "float32", ("h", "e"), "1", "Its location", domain=FINITE),
    Field("fold_chol", "float32", ("h", "e", "e"), "1", "Lower Cholesky factor of its scale", domain=FINITE),
    Field("fold_draw", "int32", ("h",), "1", "Draw of the sampler that it is of"),
)


BEHAVIOURS = Kind(
    "behaviours",
    3,
    "A Dirichlet process mixture for each action in each group of joints, and what is needed to recognise and to "
    "judge with them.",
    (
        Field("actions", "str", ("a",), "", "Names of the actions"),
        Field("groups", "str", ("g",), "", "Names of the groups; `body` is all of them together"),
        Field("alpha", "float64", ("a", "g"), "1", "Posterior mean of the concentration", domain=WEIGHT),
        Field("features", "int64", ("g",), "1", "Features of each group"),
        Field("dimensions", "int64", ("g",), "1", "Coordinates of each group"),
        Field("shift", "float64", ("g", "x"), "", "Coordinates are (features - shift) matrix", domain=FINITE),
        Field(
            "matrix",
            "float64",
            ("g", "x", "y"),
            "",
            "The same; 0 beyond the features and coordinates of a group",
            domain=FINITE,
        ),
        Field(
            "component_action",
            "int64",
            ("m",),
            "1",
            "Action of each component of the predictive mixtures",
            refers=Ref("actions"),
        ),
        Field("component_group", "int64", ("m",), "1", "Group of each component", refers=Ref("groups")),
        Field("log_weight", "float64", ("m",), "1", "log weight within action and group"),
        Field("dof", "float64", ("m",), "1", "Degrees of freedom of the component's t density", domain=WEIGHT),
        Field("location", "float64", ("m", "y"), "1", "Its location", domain=FINITE),
        Field("chol", "float64", ("m", "y", "y"), "1", "Lower Cholesky factor of its scale", domain=FINITE),
        Field("draw", "int32", ("m",), "1", "Draw of the sampler that the component is of"),
        Field("joints", "str", ("j",), "", "Joints of the skeleton"),
        Field(
            "parents",
            "int64",
            ("j",),
            "1",
            "Index of the parent of each joint; -1 none",
            refers=Ref("joints", none=True),
        ),
        Field("lengths", "float64", ("j",), "heights", "Bones of the common skeleton; NaN never seen"),
        Field(
            "group_members",
            "int64",
            ("u", 2),
            "1",
            "Group and joint of each member of a group, from the trunk outwards",
            refers=(Ref("groups"), Ref("joints")),
        ),
        Field("root", "str", (), "", "Joint that positions are measured from", refers=Ref("joints")),
        Field(
            "left",
            "str",
            ("p",),
            "",
            "Joints on the left that tell, with those on the right, where the body faces",
            refers=Ref("joints"),
        ),
        Field("right", "str", ("p",), "", "Joints on the right", refers=Ref("joints")),
        Field("top", "str", (), "", "Joint that the height is measured from", refers=Ref("joints")),
        Field("bottom", "str", ("b",), "", "Joints that the height is measured to", refers=Ref("joints")),
        Field("up", "float64", (3,), "1", "Axis of the world that points up", domain=FINITE),
        Field(
            "novelty",
            "float64",
            ("q",),
            "1",
            "How unlike its best action the poses of parts of clips are to a model of other people, ascending",
            domain=FINITE,
        ),
        *(replace(field, optional=True) for field in FOLDS),
        *_held_out(HELD_OUT[0], "l", "each held-out clip"),
        *_held_out(HELD_OUT[1], "k", "each held-out clip by its poses alone"),
        Field("preferences", "float64", ("a", "g"), "1", "W of (5.12)", domain=FINITE),
        Field("frames", "int64", ("a",), "1", "Frames of each action that there were"),
        Field("clips", "int64", ("a",), "1", "Clips of each action that there were"),
        Field("actors", "str", ("w",), "", "Whose they were"),
        Field(
            "components",
            "float64",
            ("a", "g", 3),
            "1",
            "Number of behaviours: posterior mean, 5 % and 95 %",
            domain=WEIGHT,
        ),
        Field(
            "trace_clusters", "int32", ("n", "s", "a", "g"), "1", "Number of clusters in each chain after each sweep"
        ),
        Field("r_hat", "float64", ("a", "g"), "1", "Split R-hat of the number of clusters; NaN undefined"),
        Field("ess", "float64", ("a", "g"), "1", "Effective number of its draws; NaN undefined"),
        Field(
            "behaviour_action",
            "int64",
            ("v",),
            "1",
            "Action of each behaviour of the point partitions",
            refers=Ref("actions"),
        ),
        Field("behaviour_group", "int64", ("v",), "1", "Its group", refers=Ref("groups")),
        Field("behaviour_share", "float64", ("v",), "1", "Share of the frames of the action", domain=WEIGHT),
        Field(
            "behaviour_poses",
            "float32",
            ("v", "z", "j", 3),
            "heights",
            "Frames of it, the most typical first; NaN not seen",
        ),
    ),
    together=(
        tuple(field.name for field in FOLDS),
        *(tuple(field.name for field in _held_out(prefix, "l", "")) for prefix in HELD_OUT),
    ),
)

RECOGNITION = Kind(
    "action-recognition",
    3,
    "The actions that queries (clips, some of their frames in no order, or windows along them) were recognised as.",
    (
        Field("queries", "str", (), "", "What was asked about", choices=("clip", "unordered", "window")),
        Field("clips", "str", ("q",), "", "Clip that each query is of"),
        Field("frames", "int64", ("q",), "1", "Frames of each query that could be used"),
        Field("times", "float64", ("q", 2), "s", "Start and end of each query in its clip", domain=FINITE),
        Field("actions", "str", ("a",), "", "Actions that the model knows"),
        Field("groups", "str", ("g",), "", "Groups of joints"),
        Field("answers", "str", ("q",), "", "The action, or `none`", refers=Ref("actions", also=("none",))),
        Field(
            "posterior",
            "float64",
            ("q", "a"),
            "1",
            "Posterior of each action, as if one of them it must be",
            domain=WEIGHT,
        ),
        Field("group_posterior", "float64", ("q", "g"), "1", "Posterior of the answer by each group; NaN: no frames"),
        Field(
            "novelty",
            "float64",
            ("q",),
            "1",
            "-log10 of the p-value that it is one of the actions, or how unusual its poses are; NaN not told",
        ),
        Field("threshold", "float64", (), "1", "Novelty above which the answer is `none`; infinite: never"),
        Field("truth", "str", ("q",), "", "Label of each query; empty where unknown", optional=True),
        Field("actors", "str", ("q",), "", "Whom each query is of; empty where unknown", optional=True),
        Field(
            "segment_clip",
            "str",
            ("s",),
            "",
            "Clip of each segment: windows of one answer in a row",
            optional=True,
            refers=Ref("clips"),
        ),
        Field("segment_time", "float64", ("s", 2), "s", "Start and end of each segment", optional=True, domain=FINITE),
        Field(
            "segment_answer",
            "str",
            ("s",),
            "",
            "The action, or `none`",
            optional=True,
            refers=Ref("actions", also=("none",)),
        ),
        Field(
            "segment_best",
            "str",
            ("s",),
            "",
            "The likeliest of the actions, whether it is the answer or that is `none`",
            optional=True,
            refers=Ref("actions"),
        ),
        Field("segment_posterior", "float64", ("s",), "1", "Its mean posterior", optional=True, domain=WEIGHT),
        Field("segment_novelty", "float64", ("s",), "1", "Mean novelty of the windows", optional=True),
        Field("truth_segment_clip", "str", ("t",), "", "Clip of each labelled run", optional=True, refers=Ref("clips")),
        Field("truth_segment_time", "float64", ("t", 2), "s", "Its start and end", optional=True, domain=FINITE),
        Field("truth_segment_answer", "str", ("t",), "", "Its label", optional=True),
    ),
    together=(
        ("segment_clip", "segment_time", "segment_answer", "segment_best", "segment_posterior", "segment_novelty"),
        ("truth_segment_clip", "truth_segment_time", "truth_segment_answer"),
    ),
)

EVALUATION = Kind(
    "action-evaluation",
    1,
    "Right and wrong answers of models that were trained on a part of the clips and asked about another part.",
    (
        Field("split", "str", (), "", "How the clips were parted"),
        Field("splits", "str", ("s",), "", "Name of each split"),
        Field("classes", "str", ("c",), "", "Actions"),
        Field("groups", "str", ("g",), "", "Groups of joints"),
        Field("train_clips", "int64", ("s",), "1", "Clips that were learnt from"),
        Field("train_frames", "int64", ("s",), "1", "Frames that were learnt from"),
        Field("test_clips", "int64", ("s",), "1", "Clips that were recognised"),
        Field("test_frames", "int64", ("s",), "1", "Frames that were recognised"),
        Field("sequence_confusion", "int64", ("s", "c", "c"), "clips", "Truth by answer of whole clips"),
        Field("frame_confusion", "int64", ("s", "c", "c"), "frames", "Truth by answer of single frames"),
        Field(
            "pose_sequence_confusion", "int64", ("s", "c", "c"), "clips", "The same by the poses alone, in any order"
        ),
        Field("pose_frame_confusion", "int64", ("s", "c", "c"), "frames", "The same by the pose alone"),
        Field(
            "unordered_frames", "int64", ("h",), "1", "Frames of a clip, in no order, that were asked about together"
        ),
        Field(
            "unordered_confusion",
            "int64",
            ("s", "h", "c", "c"),
            "1",
            "Truth by answer of such unordered frames, by their poses alone",
        ),
        Field(
            "group_frame_accuracy",
            "float64",
            ("s", "g"),
            "1",
            "Single frames named right by each group alone",
            domain=WEIGHT,
        ),
        Field(
            "components",
            "float64",
            ("s", "c", "g", 3),
            "1",
            "Number of behaviours: posterior mean, 5 % and 95 %",
            domain=WEIGHT,
        ),
        Field("clips", "str", ("n",), "", "Each clip that was recognised, once a split"),
        Field("clip_split", "int64", ("n",), "1", "Index of its split", refers=Ref("splits")),
        Field("clip_truth", "int64", ("n",), "1", "Index of its class", refers=Ref("classes")),
        Field("clip_answer", "int64", ("n",), "1", "Index of the answer", refers=Ref("classes")),
        Field("clip_posterior", "float64", ("n",), "1", "Posterior of the answer", domain=WEIGHT),
    ),
)

NOVELTY = Kind(
    "action-novelty",
    2,
    "What models that had not learnt an action said of its clips and of others, by people not learnt from.",
    (
        Field("people", "str", (), "", "How people were split"),
        Field("left_out", "str", ("s",), "", "The action that each model had not learnt"),
        Field("threshold", "float64", (), "1", "Novelty above which the answer is `none`; infinite: never"),
        Field("lost", "float64", ("s",), "1", "Share of the clips of other actions that are called none; NaN of none"),
        Field("caught", "float64", ("s",), "1", "Share of the clips of the action left out that are; NaN of none"),
        Field("area", "float64", ("s",), "1", "Chance that one of these is more novel than one of those"),
        Field("surprise_area", "float64", ("s",), "1", "The same by surprise alone"),
        Field("levels", "float64", ("v",), "1", "Shares of the known lost that curves are given at", domain=WEIGHT),
        Field("curve", "float64", ("v",), "1", "Share of the unknown caught there, mean over the actions; NaN none"),
        Field("surprise_curve", "float64", ("v",), "1", "The same by surprise alone"),
        Field("query_left_out", "int64", ("n",), "1", "The action left out when asked", refers=Ref("left_out")),
        Field("clips", "str", ("n",), "", "Clip that was asked about"),
        Field("truth", "str", ("n",), "", "Its label", refers=Ref("left_out")),
        Field("best", "str", ("n",), "", "The likeliest of the actions that were learnt", refers=Ref("left_out")),
        Field("posterior", "float64", ("n",), "1", "Posterior of it", domain=WEIGHT),
        Field("novelty", "float64", ("n",), "1", "-log10 of the p-value that it is one of those learnt; NaN not told"),
        Field("surprise", "float64", ("n",), "1", "How unlike all its learnt poses; NaN without frames"),
    ),
)

KINDS = (CLIPS, BEHAVIOURS, RECOGNITION, EVALUATION, NOVELTY)
