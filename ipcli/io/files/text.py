"""What the folder layouts of data sets share: text tables, files by stem, colour at the size of the depth."""

from __future__ import annotations

import codecs
from collections.abc import Sequence
from pathlib import Path

import numpy as np

from ipcli.errors import FormatError, ParameterError
from ipcli.inputs import check_file
from ipcli.io.files.images import read_image
from ipcli.measurements.names import natural

IMAGES = (".png", ".jpg", ".jpeg")
ENDS = ("\x1a", "\0")  # Ctrl-Z and zeros, which DOS put after the end of a text
MOST_DIGITS = 15  # of a whole number in a file


def require_folder(folder: Path) -> Path:
    """The folder itself, or FormatError when it is not there."""
    if not folder.is_dir():
        raise FormatError(folder, "no such folder", fix="Check the path")
    return folder


def by_stem(folder: Path, suffixes: Sequence[str]) -> dict[str, Path]:
    """Files of a folder with one of the suffixes, by stem in natural order; empty when the folder is absent.

    Two files of one stem raise FormatError: which of them was meant cannot be known.
    """
    found: dict[str, Path] = {}
    for path in sorted(folder.iterdir(), key=lambda path: natural(path.name)) if folder.is_dir() else ():
        if path.suffix.lower() not in suffixes or path.name.startswith("."):
            continue
        if path.stem in found:
            raise FormatError(
                folder,
                f"both {found[path.stem].name} and {path.name}",
                expected="one file a stem",
                fix="Remove one of them",
            )
        found[path.stem] = path
    return found


def comment_free(path: Path) -> list[tuple[int, str]]:
    """(line number, text) of the lines that hold something besides a ``#`` comment."""
    lines = (
        (number, text.split("#", 1)[0].strip()) for number, text in enumerate(read_text(path).splitlines(), start=1)
    )
    return [(number, text) for number, text in lines if text]


def words(line: str) -> list[str]:
    """The words of a line, apart by spaces, tabs, commas or semicolons."""
    return line.replace(",", " ").replace(";", " ").split()


def read_text(path: Path) -> str:
    """A UTF-8 text file without its byte order mark; FormatError when it is absent or is not text."""
    try:
        return _bytes(path).decode("utf-8-sig")
    except UnicodeDecodeError as error:
        raise FormatError(
            path, f"not a readable text file: {error}", fix="Check the path and the encoding (UTF-8)"
        ) from None


def read_any_text(path: Path) -> str:
    """A text file of an old format: UTF-8, or UTF-16 where its mark says so, or Latin-1 where it is neither.

    What DOS put after the end of a text (Ctrl-Z, zeros) is left out. FormatError when it is absent.
    """
    data = _bytes(path)
    if data.startswith((codecs.BOM_UTF16_LE, codecs.BOM_UTF16_BE)):
        text = data.decode("utf-16", errors="replace")
    else:
        try:
            text = data.decode("utf-8-sig")
        except UnicodeDecodeError:
            text = data.decode("latin-1")
    bare = text.rstrip()
    return bare.rstrip("".join(ENDS)) if bare.endswith(ENDS) else text


def whole(word: str) -> int | None:
    """The number from 0 that a word of ASCII digits is, None for any other and for one that no file needs."""
    return int(word) if word.isascii() and word.isdecimal() and len(word) <= MOST_DIGITS else None


def _bytes(path: Path) -> bytes:
    check_file(path)
    try:
        return path.read_bytes()
    except FileNotFoundError:
        raise FormatError(path, "no such file", fix="Add it, or check the path and the layout of the folder") from None
    except (OSError, ValueError) as error:  # a zero byte in a name is a ValueError
        raise FormatError(path, f"cannot be read: {' '.join(str(error).split())}", fix="Check the path") from None


def numbers(path: Path, line: int, tokens: Sequence[str], counts: Sequence[int]) -> np.ndarray:
    """The tokens of one line as float64; FormatError names the line unless their count is one of ``counts``."""
    expected = f"{' or '.join(map(str, counts))} numbers"
    if len(tokens) not in counts:
        raise FormatError(
            path, f"line {line} is cut or too long", expected=expected, got=len(tokens), fix="Check that line"
        )
    try:
        return np.array(tokens, dtype=np.float64)
    except ValueError:
        raise FormatError(
            path,
            f"line {line} holds something that is not a number",
            expected=expected,
            got=" ".join(tokens)[:60],
            fix="Check that line",
        ) from None


def read_matrix(path: Path, shape: tuple[int, int]) -> np.ndarray:
    """A text file that holds one matrix, a row a line."""
    rows = [numbers(path, line, words(text), [shape[1]]) for line, text in comment_free(path)]
    if len(rows) != shape[0]:
        raise FormatError(
            path, "wrong number of rows", expected=shape[0], got=len(rows), fix=f"Give a {shape[0]} x {shape[1]} matrix"
        )
    return np.array(rows)


def read_camera_matrix(path: Path) -> np.ndarray:
    """A camera matrix (3, 3) from a text file that holds it, or it in the corner of a 3 x 4 or 4 x 4 matrix."""
    rows = [numbers(path, line, words(text), [3, 4]) for line, text in comment_free(path)]
    if len(rows) not in (3, 4) or len({row.size for row in rows}) > 1 or len(rows) > rows[0].size:
        got = f"rows of {', '.join(str(row.size) for row in rows) or 'nothing'}"
        raise FormatError(path, "not a camera matrix", expected="3 x 3, 3 x 4 or 4 x 4", got=got, fix="Give 3 x 3")
    matrix = np.array(rows)
    padding = np.eye(4)[: len(rows), : matrix.shape[1]].copy()
    padding[:3, :3] = matrix[:3, :3]
    if not np.array_equal(matrix, padding):
        raise FormatError(path, "a camera matrix with numbers outside its 3 x 3 corner", fix="Give the 3 x 3 matrix")
    return matrix[:3, :3]


def inverse(path: Path, pose: np.ndarray) -> np.ndarray:
    """The inverse of a pose (4, 4); FormatError names the file of one that has none."""
    try:
        return np.linalg.inv(pose)
    except np.linalg.LinAlgError:
        raise FormatError(
            path, "pose is singular", expected="a rigid matrix", got=pose[:3].tolist(), fix="Remove that view"
        ) from None


def read_trajectory_log(path: Path) -> dict[int, np.ndarray]:
    """world_from_cam (4, 4) by frame number, from an Open3D .log: blocks of a line ``i j n`` and the matrix."""
    lines = comment_free(path)
    if not lines or len(lines) % 5:
        raise FormatError(
            path,
            "not a camera trajectory",
            expected="blocks of 5 lines",
            got=f"{len(lines)} lines",
            fix="Check that the file is not cut",
        )
    poses = {}
    for block in (lines[start : start + 5] for start in range(0, len(lines), 5)):
        (line, header), *rows = block
        frame = _frame(path, line, header)
        poses[frame] = np.array([numbers(path, line, text.split(), [4]) for line, text in rows])
    return poses


def _frame(path: Path, line: int, header: str) -> int:
    frame = float(numbers(path, line, header.split(), [3])[0])
    if not 0 <= frame < 10**MOST_DIGITS or frame != int(frame):
        raise FormatError(path, f"line {line} has no frame number", expected="a whole number", got=frame)
    return int(frame)


def camera_matrix(values: Sequence[float] | np.ndarray) -> np.ndarray:
    """(3, 3) from (fx, fy, cx, cy) or from the nine entries row by row; ParameterError for any other count."""
    if len(values) == 9:
        return np.array(values, dtype=np.float64).reshape(3, 3)
    if len(values) != 4:
        raise ParameterError(
            f"intrinsics {tuple(values)}: expected fx,fy,cx,cy or nine matrix entries, got {len(values)} numbers"
        )
    fx, fy, cx, cy = values
    return np.array([[fx, 0, cx], [0, fy, cy], [0, 0, 1]], dtype=np.float64)


def image_at(path: Path | None, shape: tuple[int, int]) -> np.ndarray | None:
    """The colour image (h, w, 3) uint8, resampled to the size of its depth map; None when there is no file.

    Depth sensors and networks often work at another resolution than the colour camera. An image of other proportions
    (2 %) is refused with FormatError: it does not show the same field of view.
    """
    if path is None:
        return None
    image = read_image(path)
    (height, width), (rows, columns) = shape, image.shape[:2]
    if (rows, columns) == (height, width):
        return image
    if abs(columns * height / (rows * width) - 1) > 0.02:
        raise FormatError(
            path,
            "image and depth map differ in proportions",
            expected=f"{width} x {height} or a multiple",
            got=f"{columns} x {rows}",
            fix="Register the image to the depth map, or leave it out",
        )
    import cv2

    return cv2.resize(image, (width, height), interpolation=cv2.INTER_AREA)
