"""The work folder's store: every artefact is whole or absent, checksummed, and knows what it was made from.

An artefact is a file or a folder under the work folder. It is written aside (``scratch/``), flushed to disk and renamed
into place; then its manifest is written the same way to ``manifests/NAME.json``. An artefact without a manifest, or
whose files do not have the manifest's checksums, does not count and is made again.
"""

import contextlib
import errno
import json
import os
import shutil
import tempfile
from collections.abc import Callable, Iterator
from pathlib import Path
from typing import Any

from unstructured_mg import __version__
from unstructured_mg.errors import UserError
from unstructured_mg.pipeline.keys import content_key, file_hash
from unstructured_mg.pipeline.why import changes
from unstructured_mg.playback.whole_file import whole_file

FORMAT = 1


class Store:
    """Artefacts under ``root``. Reading needs no lock; writing is for the process that holds ``lock.FolderLock``."""

    def __init__(self, root: Path):
        self.root = Path(root)
        self.scratch = self.root / "scratch"
        self.damaged: list[str] = []
        # Asked before every commit: raises where this process may not write here any more.
        self.guard: Callable[[], None] = lambda: None

    def create(self) -> None:
        """Make the work folder, or take one that is ours; anything else there is a UserError."""
        marker = self.root / "work.json"
        with user_errors(self.root):
            if self.root.exists() and not self.root.is_dir():
                raise UserError(f"{self.root}: is a file, not a folder; give another folder with -o.")
            if self.root.is_dir() and any(self.root.iterdir()) and not marker.exists():
                raise UserError(f"{self.root}: holds files that are not umg's; give an empty or new folder with -o.")
            self.root.mkdir(parents=True, exist_ok=True)
            if not marker.exists():
                text = json.dumps({"format": FORMAT, "program": "unstructured_mg"}, indent=1) + "\n"
                write_whole(marker, text.encode())
            found = _read_json(marker)
            if found is None or found.get("format") != FORMAT:
                raise UserError(f"{marker}: was written by another version of umg; build into a new folder.")

    def empty(self) -> bool:
        """Whether nothing was ever committed here."""
        return not (self.root / "manifests").exists()

    def withdraw(self, keep_folder: bool) -> None:
        """Take back what ``create`` made, where nothing came of it. Only the holder of the lock may call this."""
        with contextlib.suppress(OSError):
            shutil.rmtree(self.scratch, ignore_errors=True)
            for name in ("timings.json", "lock", "work.json"):
                (self.root / name).unlink(missing_ok=True)
            if not keep_folder:
                self.root.rmdir()

    def clear_scratch(self) -> None:
        """Remove what a killed writer left. Only the holder of the lock may call this."""
        with user_errors(self.scratch):
            shutil.rmtree(self.scratch, ignore_errors=True)
            self.scratch.mkdir(parents=True, exist_ok=True)

    def new_scratch(self) -> Path:
        """A fresh folder on the work folder's own disk, for an artefact in the making."""
        with user_errors(self.scratch):
            self.scratch.mkdir(parents=True, exist_ok=True)
            return Path(tempfile.mkdtemp(dir=self.scratch))

    def path(self, name: str) -> Path:
        return self.root / name

    def manifest(self, name: str) -> dict[str, Any] | None:
        """The manifest of an artefact, or None where there is none that can be read."""
        return _read_json(self._manifest_path(name))

    def find(self, name: str, inputs: dict[str, Any]) -> Path | None:
        """The artefact's path where it was made from ``inputs`` and is intact, else None.

        A damaged one is noted in ``self.damaged``.
        """
        manifest = self.manifest(name)
        if manifest is None or manifest.get("key") != content_key(inputs) or not _tells(manifest, name, inputs):
            return None
        return self.verify(name)

    def absent(self, name: str) -> bool:
        """Whether there is nothing of the artefact, not even a damaged part."""
        return not self._manifest_path(name).exists() and not self.path(name).exists()

    def why(self, name: str, inputs: dict[str, Any]) -> str:
        """Why ``find`` has just found nothing, as the end of a sentence that begins with the name."""
        manifest = self.manifest(name)
        if manifest is None:
            return "has not been made yet" if not self.path(name).exists() else "has no manifest that can be read"
        if not self.path(name).exists():
            return "is gone"
        if name in self.damaged:
            return "is damaged"
        # As JSON has it: the manifest knows no tuples.
        different = changes(manifest.get("inputs") or {}, json.loads(json.dumps(inputs)))
        return f"is out of date: {', '.join(different)}" if different else "has a damaged manifest"

    def verify(self, name: str) -> Path | None:
        """The artefact's path where it has a manifest and every checksum holds, whatever it was made from."""
        manifest = self.manifest(name)
        if manifest is None:
            return None
        path = self.path(name)
        try:
            intact = _checksums(path) == manifest.get("files")
        except OSError:
            intact = False
        if not intact:
            if name not in self.damaged:
                self.damaged.append(name)
            return None
        return path

    def commit(self, name: str, inputs: dict[str, Any], made: Path) -> Path:
        """Move ``made`` (a file or folder in scratch) into place as artefact ``name``, replacing what is there."""
        self.guard()
        target, manifest_path = self.path(name), self._manifest_path(name)
        with user_errors(target):
            manifest = {
                "artefact": name,
                "version": __version__,
                "key": content_key(inputs),
                "inputs": inputs,
                "files": _checksums(made),
            }
            flush_tree(made)
            target.parent.mkdir(parents=True, exist_ok=True)
            manifest_path.parent.mkdir(parents=True, exist_ok=True)
            self.remove(name)
            os.replace(made, target)
            flush_folder(target.parent)
            write_whole(manifest_path, (json.dumps(manifest, indent=1, sort_keys=True) + "\n").encode())
        return target

    def commit_json(self, name: str, inputs: dict[str, Any], content: Any) -> Path:
        """Commit one JSON file."""
        folder = self.new_scratch()
        made = folder / "content.json"
        with user_errors(self.path(name)):
            made.write_text(json.dumps(content, indent=1, allow_nan=False) + "\n")
        path = self.commit(name, inputs, made)
        folder.rmdir()
        return path

    def remove(self, name: str) -> None:
        """Remove an artefact: its manifest first, so that a half-removed one does not count."""
        self._manifest_path(name).unlink(missing_ok=True)
        path = self.path(name)
        if path.is_dir():
            shutil.rmtree(path)
        else:
            path.unlink(missing_ok=True)

    def names(self, group: str) -> list[str]:
        """Names of all artefacts ``group/...`` that have a manifest, sorted."""
        folder = self.root / "manifests" / group
        return sorted(f"{group}/{path.name.removesuffix('.json')}" for path in folder.glob("*.json"))

    def _manifest_path(self, name: str) -> Path:
        return self.root / "manifests" / f"{name}.json"


@contextlib.contextmanager
def user_errors(path: Path) -> Iterator[None]:
    """Turn the system's refusals (disk full, read-only, no permission) into one sentence that names ``path``."""
    try:
        yield
    except OSError as error:
        remedies = {
            errno.ENOSPC: "free some space and run the same command again: finished work is kept",
            errno.EDQUOT: "free some of your quota and run the same command again: finished work is kept",
            errno.EACCES: "give a folder that you may write to",
            errno.EPERM: "give a folder that you may write to",
            errno.EROFS: "give a folder on a disk that can be written",
        }
        # NumPy tells of a full disk in words alone.
        code = error.errno or (errno.ENOSPC if "free space" in str(error) else 0)
        remedy = remedies.get(code, "mend that and run the same command again: finished work is kept")
        raise UserError(f"{path}: {error.strerror or error}; {remedy}.") from error


def write_whole(path: Path, content: bytes) -> None:
    """Write a file so that it is there whole or not at all."""
    with whole_file(path) as stream:
        stream.write(content)
    flush_folder(path.parent)


def flush_tree(path: Path) -> None:
    """Flush a file, or every file and folder below a folder, to the disk."""
    if path.is_dir():
        for child in sorted(path.iterdir()):
            flush_tree(child)
        os.chmod(path, 0o755)
        flush_folder(path)
    else:
        with open(path, "rb") as stream:
            os.fsync(stream.fileno())


def flush_folder(path: Path) -> None:
    """Flush a folder's entries. Windows has no such call and needs none."""
    if os.name == "nt":
        return
    descriptor = os.open(path, os.O_RDONLY)
    try:
        os.fsync(descriptor)
    finally:
        os.close(descriptor)


def _checksums(path: Path) -> dict[str, str]:
    if path.is_dir():
        files = sorted(child for child in path.rglob("*") if child.is_file())
        return {child.relative_to(path).as_posix(): file_hash(child) for child in files}
    return {"": file_hash(path)}


def _tells(manifest: dict[str, Any], name: str, inputs: dict[str, Any]) -> bool:
    """Whether a manifest still says what was written: nobody reads its words, but a user may."""
    return manifest.get("artefact") == name and manifest.get("inputs") == json.loads(json.dumps(inputs))


def _read_json(path: Path) -> dict[str, Any] | None:
    try:
        content = json.loads(path.read_text())
    except (OSError, ValueError, RecursionError):
        return None
    return content if isinstance(content, dict) else None
