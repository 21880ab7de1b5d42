"""The page's scripts in node: those that need no page."""

import json
import shutil
import subprocess
import tempfile
from importlib.resources import files
from pathlib import Path
from typing import Any

import pytest

SCRIPTS = ("random", "motion", "graph", "reels", "decode", "player")


def in_node(body: str, data: Any = None, *scripts: str) -> Any:
    """What ``body``, an async function's with ``data`` and ``umg``, returns; by way of JSON. Skips without node."""
    node = shutil.which("node")
    if node is None:
        pytest.skip("node is not there: make tools")
    folder = files("unstructured_mg.playback").joinpath("web")
    source = "\n".join(folder.joinpath(f"{name}.js").read_text(encoding="utf-8") for name in scripts or SCRIPTS)
    with tempfile.TemporaryDirectory() as place:
        given = Path(place) / "data.json"
        given.write_text(json.dumps(data))
        program = Path(place) / "program.js"
        program.write_text(
            f"{source}\n(async (data, umg) => {{{body}}})"
            f"(JSON.parse(require('fs').readFileSync({json.dumps(str(given))}, 'utf8')), globalThis.umg)"
            ".then((told) => console.log(JSON.stringify(told ?? null)))",
            encoding="utf-8",
        )
        ended = subprocess.run([node, str(program)], capture_output=True, text=True, timeout=120)
    assert ended.returncode == 0, ended.stderr
    return json.loads(ended.stdout)
