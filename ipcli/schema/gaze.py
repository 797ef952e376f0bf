"""The kinds of gaze-sfm (thesis section 3.2)."""

from ipcli.schema.fields import DISTANCE, FINITE, Domain, Field, Kind

KNOWN = Domain("finite, or NaN where unknown", nan=True)
COUNT = Domain(">= 0", 0.0)
INDEX = Domain(">= -1", -1.0)
LENSES = ("pinhole", "radtan", "equidistant", "fisheye624")
OUTCOMES = ("hit", "no depth", "lost", "invalid", "outside", "far")

RIG = (
    Field("rig/sizes", "int64", ("c", 2), "px", "Width and height of each camera's pictures"),
    Field("rig/intrinsics", "float64", ("c", 3, 3), "px", "K; pixel centres at integers, as in OpenCV", domain=FINITE),
    Field("rig/models", "str", ("c",), "", "Lens of each camera", choices=LENSES),
    Field("rig/distortion", "float64", ("c", 12), "1", "Coefficients of the lens, NaN beyond them", domain=KNOWN),
    Field("rig/cam_from_rig", "float64", ("c", 4, 4), "m", "The rig's frame is camera 0's", domain=FINITE),
)
GAZE = (
    Field("gaze/times", "float64", ("n",), "s", "Time of each gaze sample, ascending", True, FINITE),
    Field("gaze/pixels", "float64", ("n", 2), "px", "Gaze in camera 0's picture, distortion included", True, KNOWN),
    Field("gaze/valid", "uint8", ("n",), "1", "1: confident, worn, no blink", True),
    Field("gaze/directions", "float64", ("n", 3), "1", "Unit rays in the rig's frame; NaN: the pixel's", True, KNOWN),
    Field("gaze/origins", "float64", ("n", 3), "m", "Where the rays begin, in the rig's frame", True, KNOWN),
    Field("gaze/labels", "str", ("n",), "", "What was looked at, where it is known", True),
)

RECORDING = Kind(
    "recording",
    1,
    "A head-mounted recording: calibrated pictures of one or two cameras (or one with depth), gaze, truth where known.",
    (
        Field("names", "str", ("k",), "", "Name of each frame"),
        Field("times", "float64", ("k",), "s", "Time of each frame, ascending", domain=FINITE),
        *RIG,
        Field("frames/*/left", "uint8", ("x",), "", "The picture of camera 0 as a PNG or JPEG file"),
        Field("frames/*/right", "uint8", ("y",), "", "The picture of camera 1", optional=True),
        Field("frames/*/depth", "float32", ("h", "w"), "m", "Depth along camera 0's axis", True, DISTANCE),
        *GAZE,
        Field("truth", "float64", ("k", 4, 4), "m", "world_from_rig; NaN unknown", True, KNOWN),
        Field("targets", "float64", ("t", 3), "m", "Places that were looked at, in the truth's frame", True, FINITE),
        Field("target_names", "str", ("t",), "", "Their names", True),
        Field("imu", "float64", ("m", 7), "s, rad/s, m/s^2", "Time, angular rate, acceleration", True, FINITE),
        Field("source", "str", (), "", "The layout that it was imported from"),
    ),
)

EXPERIMENT = Kind(
    "gaze-experiment",
    1,
    "Head path, map, coherent subsequences and points of regard: E of (3.34). H is `world_from_rig`, M `map/points`, B "
    "`observer`, Delta T `frame_gap`, P `por/points`, Delta t `gaze_gap`, R_POR `shown/pixels`. World: the rig of "
    "the first frame; metres.",
    (
        Field("names", "str", ("k",), "", "Name of each frame"),
        Field("times", "float64", ("k",), "s", "Time of each frame, ascending", domain=FINITE),
        *RIG,
        Field("world_from_rig", "float64", ("k", 4, 4), "m", "Head pose; NaN where lost", domain=KNOWN),
        Field(
            "covariance",
            "float64",
            ("k", 6, 6),
            "rad^2, m^2",
            "Of the twist (omega, v) on the left of rig_from_world; NaN where lost",
            domain=KNOWN,
        ),
        Field("online", "float64", ("k", 4, 4), "m", "Head pose as known at that frame", domain=KNOWN),
        Field("lost", "uint8", ("k",), "1", "1: no pose"),
        Field("how", "str", ("k",), "", "How the pose was found", choices=("first", "predicted", "recognised", "lost")),
        Field("reasons", "str", ("k",), "", "Why a frame was lost; else empty"),
        Field("in_map", "uint8", ("k",), "1", "1: the frame is part of the map"),
        Field("matched", "int64", ("k",), "1", "Map points that the pose rests on", domain=COUNT),
        Field("stereo", "int64", ("k",), "1", "Features matched between the cameras", domain=COUNT),
        Field("error", "float64", ("k",), "px", "Reprojection error of the pose; NaN where lost", domain=KNOWN),
        Field("vertical", "float64", ("k",), "px", "Median vertical disparity", domain=KNOWN),
        Field("subsequence", "int64", ("k",), "1", "Coherent subsequence; -1 where lost", domain=INDEX),
        Field("keyframe", "uint8", ("k",), "1", "1: begins a subsequence"),
        Field("gric_f", "float64", ("k",), "1", "Gamma(F) of (3.5) to the keyframe", domain=KNOWN),
        Field("gric_h", "float64", ("k",), "1", "Gamma(H)", domain=KNOWN),
        Field("change", "float64", ("k",), "px", "delta of (3.7) as selected", domain=KNOWN),
        Field("parted", "float64", ("k",), "sigma", "Angle of the gaze to the subsequence's PORs", domain=KNOWN),
        Field("observer", "float64", ("k", 3), "m", "The scene's middle as the head sees it (B)", domain=KNOWN),
        Field("frame_gap", "float64", (), "s", "Median time between frames", domain=KNOWN),
        Field("gaze_gap", "float64", (), "s", "Median time between gaze samples", domain=KNOWN),
        Field("offset", "float64", (), "px", "Correction of the right camera's principal point that was applied"),
        Field("offset_blocks", "float64", ("b",), "px", "Offsets of contiguous parts of the sequence", domain=KNOWN),
        Field("offset_estimate", "float64", (), "px", "Offset of the whole sequence; NaN not estimated", domain=KNOWN),
        Field("offset_error", "float64", (), "px", "Its standard error, from the blocks", domain=KNOWN),
        *GAZE,
        Field("por/points", "float64", ("n", 3), "m", "Point of regard in the world; NaN unless hit", True, KNOWN),
        Field("por/covariance", "float64", ("n", 3, 3), "m^2", "Of the point", True, KNOWN),
        Field("por/outcome", "str", ("n",), "", "What became of the sample", True, choices=OUTCOMES),
        Field("por/frame", "int64", ("n",), "1", "Nearest frame; -1 none", True, INDEX),
        Field("por/origins", "float64", ("n", 3), "m", "Where the ray begins, in the world", True, KNOWN),
        Field("por/directions", "float64", ("n", 3), "1", "Unit ray in the world", True, KNOWN),
        Field("por/fixation", "int64", ("n",), "1", "Fixation of the sample; -1 none", True, INDEX),
        Field("fixations/span", "int64", ("f", 2), "1", "First sample and the one after the last", True, COUNT),
        Field("fixations/points", "float64", ("f", 3), "m", "Mean of its points of regard", True, KNOWN),
        Field("fixations/covariance", "float64", ("f", 3, 3), "m^2", "Of that mean", True, KNOWN),
        Field("shown/frame", "int64", ("q",), "1", "Frame of each reprojected POR", True, COUNT),
        Field("shown/sample", "int64", ("q",), "1", "Gaze sample of it", True, COUNT),
        Field("shown/pixels", "float64", ("q", 2), "px", "Where it is in the picture of camera 0", True, FINITE),
        Field("map/points", "float64", ("p", 3), "m", "Points of the map", domain=FINITE),
        Field("map/grey", "uint8", ("p",), "", "Grey level of each"),
        Field("map/descriptors", "uint8", ("p", 128), "1", "RootSIFT of each, to localise in this map", True),
        Field("map/seen", "int64", ("p",), "1", "Frames that see it", domain=COUNT),
        Field("map/sightings", "int64", ("m", 3), "1", "Frame, camera and point of each sighting", domain=COUNT),
        Field("map/pixels", "float64", ("m", 2), "px", "Where, distortion included", domain=FINITE),
        Field("pictures", "uint8", ("t", "h", "w", 3), "", "Some frames, made small"),
        Field("picture_frames", "int64", ("t",), "1", "Which frames they are", domain=COUNT),
        Field("truth", "float64", ("k", 4, 4), "m", "True world_from_rig; NaN unknown", True, KNOWN),
        Field(
            "targets", "float64", ("a", 3), "m", "True places that were looked at, in the truth's frame", True, FINITE
        ),
        Field("target_names", "str", ("a",), "", "Their names", True),
        Field("subsequences/frames", "int64", ("s", 2), "1", "First frame and the one after the last", domain=COUNT),
        Field("subsequences/regards", "int64", ("s",), "1", "Points of regard in each", domain=COUNT),
        Field("subsequences/points", "float64", ("s", 3), "m", "Median of its points of regard", domain=KNOWN),
        Field("subsequences/extent", "float64", ("s",), "m", "Root mean square distance from it", domain=KNOWN),
        Field(
            "accuracy/path",
            "float64",
            (4,),
            "m, m, 1, m",
            "Against the truth: path, path with scale, that scale, path as known online",
            True,
            KNOWN,
        ),
        Field("accuracy/labels", "str", ("g",), "", "What was looked at", True),
        Field("accuracy/regards", "int64", ("g",), "1", "Points of regard there", True, COUNT),
        Field("accuracy/dwell", "float64", ("g",), "s", "Time of gaze on it", True, KNOWN),
        Field("accuracy/rms", "float64", ("g",), "m", "Distance from the true place, root mean square", True, KNOWN),
        Field("accuracy/inside", "float64", ("g", 2), "1", "Share of truth in the 68 and 95 % regions", True, KNOWN),
        Field("aoi/names", "str", ("i",), "", "Areas of interest", True),
        Field("aoi/of_sample", "int64", ("n",), "1", "Area of each gaze sample; -1 none", True, INDEX),
        Field("aoi/dwell", "float64", ("i",), "s", "Time of gaze on each", True, FINITE),
        Field("aoi/share", "float64", ("i",), "1", "Of the time with a point of regard", True, KNOWN),
        Field("aoi/visits", "int64", ("i",), "1", "Times the gaze came to it", True, COUNT),
        Field("aoi/fixations", "int64", ("i",), "1", "Fixations most of which lie there", True, COUNT),
        Field("aoi/first", "float64", ("i",), "s", "First look, after the first sample; NaN never", True, KNOWN),
        Field(
            "aoi/transitions", "int64", ("i", "i"), "1", "Times the gaze went from one (row) to another", True, COUNT
        ),
        Field("landmarks/names", "str", ("lm",), "", "Landmarks that the world was laid on", True),
        Field("landmarks/places", "float64", ("lm", 3), "m", "Where they are said to be", True, FINITE),
        Field("landmarks/found", "float64", ("lm", 3), "m", "Where the run sees them; NaN not seen", True, KNOWN),
        Field("landmarks/scale", "float64", (), "1", "Scale that the run was given; 1 for a rigid alignment", True),
        Field("notes", "str", ("o",), "", "What was left out or is doubtful, and why"),
        Field("source", "str", (), "", "Layout of the recording"),
    ),
)

KINDS = (RECORDING, EXPERIMENT)
