"""Content keys: what an artefact was made from, as one hash."""

import hashlib
import json
from pathlib import Path
from typing import Any


def content_key(inputs: dict[str, Any]) -> str:
    """sha256 of ``inputs`` (JSON-ready) in canonical form: equal inputs, equal key, whatever the order of the dict."""
    text = json.dumps(inputs, sort_keys=True, separators=(",", ":"), allow_nan=False)
    return hashlib.sha256(text.encode()).hexdigest()


def file_hash(path: Path) -> str:
    """sha256 of a file's bytes."""
    with open(path, "rb") as stream:
        return hashlib.file_digest(stream, "sha256").hexdigest()
