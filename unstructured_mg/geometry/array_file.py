"""Reading ``.npz`` files that may not be what they seem: nothing is unpickled, and no promise is believed unread."""

import io
import json
import zipfile
import zlib
from collections.abc import Iterator, Mapping
from contextlib import contextmanager
from pathlib import Path

import numpy as np

from unstructured_mg.errors import UserError

# What an array must be: its type, its shape (names stand for lengths that agree within the file), and, where it holds
# indices, into how many: a name of a length, or None.
Expected = tuple[str, tuple[int | str, ...], str | None]


def read_arrays(
    path: Path, expected: Mapping[str, Expected], optional: Mapping[str, Expected] | None = None
) -> dict[str, np.ndarray]:
    """The arrays that ``np.savez`` wrote to ``path``: all of ``expected``, and of ``optional`` those that are there.

    A name in ``optional`` that ends in ``*`` stands for all that begin like it. Floating point values may be anything.

    Raises
    ------
    UserError
        Where the file is missing or no such archive, or an array is missing, damaged, of another type or shape than
        expected, or holds an index out of range.
    """
    optional = optional or {}
    with as_written(path):
        lengths: dict[str, int] = {}
        with zipfile.ZipFile(path) as archive:
            size = path.stat().st_size
            stored = {name.removesuffix(".npy"): archive.getinfo(name) for name in archive.namelist()}
            arrays = {}
            for name in [*expected, *(name for name in sorted(stored) if name not in expected)]:
                wanted = expected.get(name) or _wanted(name, optional)
                if wanted is None:
                    continue
                if name not in stored:
                    raise ValueError(f"{name} is missing")
                info = stored[name]
                if info.compress_type != zipfile.ZIP_STORED or info.file_size > size:
                    raise ValueError(f"{name} promises more than the file holds")
                arrays[name] = _read(name, archive.read(info), wanted, lengths)
        for name, array in arrays.items():
            into = (expected.get(name) or _wanted(name, optional) or ("", (), None))[2]
            if into is not None and array.size and not 0 <= array.min() <= array.max() < lengths[into]:
                raise ValueError(f"{name} holds an index out of 0 to {lengths[into] - 1}")
    return arrays


@contextmanager
def as_written(path: Path) -> Iterator[None]:
    """Whatever goes wrong while ``path`` is read tells the user that it is not what umg wrote there."""
    try:
        yield
    except UserError:
        raise
    except FileNotFoundError:
        raise UserError(f"{path}: is missing; {_REMEDY}.") from None
    except OSError as error:
        raise UserError(f"{path}: cannot be read ({error.strerror or error}); {_REMEDY}.") from None
    except _DAMAGE as error:
        what = f"{type(error).__name__} {error}" if isinstance(error, LookupError) else str(error)
        raise UserError(f"{path}: is not what umg wrote there ({' '.join(what.split())[:200]}); {_REMEDY}.") from None


_REMEDY = "remove it and run umg build again, which makes it anew"
# What readers meet in files that were damaged or made up.
_DAMAGE = (
    ValueError,
    TypeError,
    LookupError,
    AttributeError,
    ArithmeticError,
    RecursionError,
    EOFError,
    MemoryError,
    NotImplementedError,
    RuntimeError,
    zipfile.BadZipFile,
    zlib.error,
)


def read_json(path: Path) -> object:
    """The content of a JSON file; UserError where it is missing or no JSON, or holds a number that is not finite."""

    def refuse(word: str) -> float:
        raise ValueError(f"it holds {word}")

    with as_written(path):
        return json.loads(path.read_text(encoding="utf-8"), parse_constant=refuse)


def _wanted(name: str, optional: Mapping[str, Expected]) -> Expected | None:
    if name in optional:
        return optional[name]
    return next((each for key, each in optional.items() if key.endswith("*") and name.startswith(key[:-1])), None)


def _read(name: str, data: bytes, expected: Expected, lengths: dict[str, int]) -> np.ndarray:
    dtype, shape, _ = expected
    stream = io.BytesIO(data)
    version = np.lib.format.read_magic(stream)
    if version not in ((1, 0), (2, 0)):
        raise ValueError(f"{name} has a header of version {version}")
    read = np.lib.format.read_array_header_1_0 if version == (1, 0) else np.lib.format.read_array_header_2_0
    found, fortran, kind = read(stream)
    body = data[stream.tell() :]
    count = int(np.prod([int(length) for length in found], dtype=object)) if found else 1
    if kind != np.dtype(dtype):
        raise ValueError(f"{name}: expected {dtype}, got {kind}")
    if any(length < 0 for length in found) or len(found) != len(shape) or count * kind.itemsize != len(body):
        raise ValueError(f"{name}: expected {shape}, got {found} in {len(body)} bytes")
    for length, wanted in zip(found, shape, strict=True):
        if length != (lengths.setdefault(wanted, length) if isinstance(wanted, str) else wanted):
            raise ValueError(f"{name}: expected {shape}, got {found}, with {lengths}")
    return np.frombuffer(body, kind).reshape(found, order="F" if fortran else "C").copy(order="K")
