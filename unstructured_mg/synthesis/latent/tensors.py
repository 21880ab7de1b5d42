"""Named arrays in the safetensors format: nothing in such a file can run, unlike a pickle."""

import json
from collections.abc import Mapping
from typing import Any

import numpy as np

from unstructured_mg.errors import UserError


def packed(tensors: Mapping[str, np.ndarray], notes: Mapping[str, str]) -> bytes:
    """``tensors`` and text ``notes`` as a safetensors file's content; the same content gives the same bytes."""
    contiguous = {name: np.ascontiguousarray(tensors[name]) for name in sorted(tensors)}
    # The library writes several notes in an order of its own; as one text they keep ours.
    return _library().save(contiguous, {"notes": json.dumps(dict(notes), sort_keys=True)})


def unpacked(content: bytes, name: str) -> tuple[dict[str, np.ndarray], dict[str, str]]:
    """Arrays and notes of a safetensors file's ``content``. Raises UserError, beginning with ``name``, for others."""
    library = _library()
    try:
        tensors = library.load(content)
        header = json.loads(content[8 : 8 + int.from_bytes(content[:8], "little")])
        notes = json.loads(header["__metadata__"]["notes"])
        if not isinstance(notes, dict) or not all(isinstance(value, str) for value in notes.values()):
            raise ValueError("its notes are not texts")
    except Exception as error:  # the library has errors of its own beside ValueError, KeyError and TypeError
        text = " ".join(str(error).split())
        raise UserError(f"{name}: it is not readable as a safetensors file of umg's ({text}); make it again.") from None
    return tensors, notes


def _library() -> Any:
    try:
        import safetensors.numpy
    except ImportError:
        raise UserError(
            "latent models need safetensors, which is not installed; run pip install 'unstructured_mg[learn]'."
        ) from None
    return safetensors.numpy
