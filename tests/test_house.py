"""The order of the rooms: data flow one way, so imports do too."""

import ast
from pathlib import Path

import pytest

import unstructured_mg

PACKAGE = Path(unstructured_mg.__file__).parent
ROOMS = ("geometry", "capture", "matching", "tracking", "synthesis", "graph", "playback", "pipeline")
EVERYWHERE = {"errors", "_native"}
# Of the package itself only the version: everything else has a room.
VERSION = "__version__"


def room_of(path: Path) -> str:
    return path.relative_to(PACKAGE).parts[0].removesuffix(".py")


def imported_modules(path: Path) -> set[str]:
    """Every module, or name out of one, that a file imports, at its head or inside a function."""
    found = set()
    for node in ast.walk(ast.parse(path.read_text(encoding="utf-8"))):
        if isinstance(node, ast.Import):
            found |= {alias.name for alias in node.names}
        elif isinstance(node, ast.ImportFrom):
            assert node.level == 0, f"{path}: imports are absolute"
            found |= {str(node.module), *(f"{node.module}.{alias.name}" for alias in node.names)}
    return found


def imported_rooms(path: Path) -> set[str]:
    return {name.split(".")[1] for name in imported_modules(path) if name.startswith(PACKAGE.name + ".")}


@pytest.mark.parametrize("room", ROOMS)
def test_a_room_imports_only_from_rooms_before_it(room):
    files = sorted((PACKAGE / room).rglob("*.py"))
    assert files
    allowed = {VERSION, *EVERYWHERE, *ROOMS[: ROOMS.index(room) + 1]}
    wrong = {str(path): imported_rooms(path) - allowed for path in files if imported_rooms(path) - allowed}
    assert not wrong


def test_every_file_is_in_a_room():
    outside = {room_of(path) for path in PACKAGE.rglob("*.py")} - set(ROOMS)
    assert outside == {"__init__", "errors", "cli"}
    assert imported_rooms(PACKAGE / "errors.py") == set()


def test_no_two_files_import_each_other():
    files = {".".join(path.relative_to(PACKAGE.parent).with_suffix("").parts): path for path in PACKAGE.rglob("*.py")}
    waits = {name: imported_modules(path) & set(files) for name, path in files.items()}
    while free := {name for name, needed in waits.items() if not needed}:
        waits = {name: needed - free for name, needed in waits.items() if name not in free}
    assert not waits, "a circle of imports goes through these files"
