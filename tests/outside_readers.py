"""Programs that nobody of this project wrote, asked what they find in a file; a test that lacks one is skipped."""

import json
import shutil
import subprocess
from pathlib import Path
from typing import Any

import pytest

TOOLS = Path(__file__).parent.parent / ".tools"

_VALIDATE = """
const validator = require(process.argv[1] + "/gltf-validator"), fs = require("fs");
validator.validateBytes(new Uint8Array(fs.readFileSync(process.argv[2]))).then(
  report => console.log(JSON.stringify(report)), error => { console.error(error); process.exit(1); });
"""


def gltf_report(path: Path) -> dict[str, Any]:
    """The report of the Khronos glTF validator, as JSON."""
    modules = TOOLS / "node_modules"
    node = shutil.which("node")
    if node is None or not (modules / "gltf-validator").is_dir():
        pytest.skip("node and gltf-validator are not there: make tools")
    done = subprocess.run([node, "-e", _VALIDATE, str(modules), str(path)], capture_output=True, text=True, timeout=60)
    assert done.returncode == 0, done.stderr
    return json.loads(done.stdout)


def program(name: str) -> str:
    """The path of a program that ``make tools`` installs."""
    path = shutil.which(name)
    if path is None:
        pytest.skip(f"{name} is not there: make tools")
    return path
