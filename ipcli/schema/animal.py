"""Kinds of artefacts of chapter 6."""

from __future__ import annotations

from ipcli.schema.fields import FINITE, ROTATION, WEIGHT, Domain, Field, Kind, Ref

POSITIVE = Domain("finite, > 0", 0.0, closed=False)

TREE = (
    Field("parts", "str", ("p",), "", "Name of each part"),
    Field(
        "parents",
        "int16",
        ("p",),
        "",
        "Index of the parent of each part; -1 for the root",
        refers=Ref("parts", none=True),
    ),
)

REGISTERED = (
    Field("registrations/*/part", "int16", (), "", "Part whose aspects in two images were registered", optional=True,
          refers=Ref("parts")),
    Field("registrations/*/images", "str", (2,), "", "Names of the first and the second image", optional=True),
    Field("registrations/*/transform", "float64", (4, 4), "px", "first_from_second of (column, row, depth)",
          optional=True, domain=FINITE),
    Field("registrations/*/residual", "float64", (), "1", "What is left of the heights of both", optional=True,
          domain=Domain("0 or above", 0.0)),
    Field("registrations/*/is_used", "bool", (), "", "Whether the two were merged", optional=True),
    Field("registrations/*/heights", "float32", ("hr", "wr"), "px", "Heights of the first", optional=True,
          domain=FINITE),
    Field("registrations/*/before", "float32", ("hr", "wr"), "px", "Of the second laid over it, at the start",
          optional=True, domain=FINITE),
    Field("registrations/*/after", "float32", ("hr", "wr"), "px", "The same in the end", optional=True, domain=FINITE),
)  # fmt: skip

ASPECTS = Kind(
    "animal-aspects",
    1,
    "Parts of an animal, each lifted from its mask in one image to half of a closed surface.",
    (
        *TREE,
        Field("aspects/*/image", "str", (), "", "Name of the image"),
        Field("aspects/*/part", "int16", (), "", "Index of the part", refers=Ref("parts")),
        Field(
            "aspects/*/heights", "float32", ("h", "w"), "px", "Half thickness over the mask, 0 outside", domain=WEIGHT
        ),
        Field("aspects/*/corner", "int32", (2,), "px", "Column and row of the first height in the image"),
        Field("aspects/*/area", "int64", (), "px", "Pixels in which the image shows the part"),
        Field("load", "str", (), "", "What lifted the masks"),
        *REGISTERED,
    ),
)

COMPONENTS = Kind(
    "animal-components",
    1,
    "Where each part of an animal is: fields on one grid, negative inside, and the cameras of the images.",
    (
        *TREE,
        Field("origin", "float64", (3,), "unit", "World position of the first grid point", domain=FINITE),
        Field("spacing", "float64", (), "unit", "Side of a voxel", domain=POSITIVE),
        Field(
            "fields",
            "float32",
            ("p", "nx", "ny", "nz"),
            "voxel",
            "Of each part: carved by the labels, rounded by its aspect",
            domain=FINITE,
        ),
        Field("images", "str", ("k",), "", "Name of each image of the reference pose"),
        Field("rotations", "float64", ("k", 3, 3), "1", "cam_from_world of each image", domain=ROTATION),
        Field("scales", "float64", ("k",), "px/unit", "Scale of each image", domain=POSITIVE),
        Field("shifts", "float64", ("k", 2), "px", "Column and row of the world's origin", domain=FINITE),
        Field(
            "bent_overlap",
            "float64",
            (),
            "1",
            "Overlap of the labels of the other pose's model, bent, with the images; absent where none was bent",
            optional=True,
            domain=WEIGHT,
        ),
    ),
)

MODEL = Kind(
    "animal-model",
    1,
    "A closed surface of an animal whose faces know their part, and the images it was made from.",
    (
        *TREE,
        Field("name", "str", (), "", "Name of the animal"),
        Field("vertices", "float32", ("n", 3), "unit", "x forward, y to its left, z up", domain=FINITE),
        Field("faces", "int32", ("m", 3), "", "Indices of vertices, counter-clockwise from outside",
              refers=Ref("vertices")),
        Field("face_part", "int16", ("m",), "", "Index of the part of each face", refers=Ref("parts")),
        Field("seen_by", "uint16", ("n",), "", "Images that saw the vertex; 0: the model's guess"),
        Field("images", "str", ("k",), "", "Name of each image of the reference pose"),
        Field("views", "str", ("k",), "", "Name of its view; empty: found from the masks"),
        Field("rotations", "float64", ("k", 3, 3), "1", "cam_from_world of each image", domain=ROTATION),
        Field("scales", "float64", ("k",), "px/unit", "Scale of each image", domain=POSITIVE),
        Field("shifts", "float64", ("k", 2), "px", "Column and row of the world's origin", domain=FINITE),
        Field("overlaps", "float64", ("k",), "1", "Share of pixels whose part agrees", domain=WEIGHT),
        Field("part_overlaps", "float64", ("k", "p"), "1", "The same for each part; NaN where neither shows it",
              domain=Domain("0 to 1, or NaN", 0.0, nan=True)),
        Field("bodies/*/part", "int16", (), "", "Index of the part that this closed body is", optional=True,
              refers=Ref("parts")),
        Field("bodies/*/vertices", "float32", ("n", 3), "unit", "The part alone, closed", domain=FINITE, optional=True),
        Field("bodies/*/faces", "int32", ("m", 3), "", "Indices of its vertices", optional=True,
              refers=Ref("bodies/*/vertices")),
        Field("pictures/*/labels", "int16", ("h", "w"), "", "Part of each pixel + 1; 0 background", optional=True,
              refers=Ref("parts", none=True, base=1)),
        Field("pictures/*/rendered", "int16", ("h", "w"), "", "The same of the model", optional=True,
              refers=Ref("parts", none=True, base=1)),
        Field("pictures/*/picture", "uint8", ("h", "w", 3), "", "RGB", optional=True),
        Field("warnings", "str", ("q",), "", "What is odd about the masks"),
        Field("doubts", "str", ("d",), "", "What makes the model doubtful", optional=True),
        *REGISTERED,
    ),
    together=(
        ("bodies/*/part", "bodies/*/vertices", "bodies/*/faces"),
        ("pictures/*/labels", "pictures/*/rendered"),
    ),
    needs=(("pictures/*/picture", "pictures/*/labels"),),
)  # fmt: skip

KINDS = (ASPECTS, COMPONENTS, MODEL)
