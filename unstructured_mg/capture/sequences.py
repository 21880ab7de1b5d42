"""Files that hold, or list, many frames: which a folder has, which frames are in them, and reading one of these."""

from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path

from unstructured_mg.capture.frame_error import FrameError, malformed
from unstructured_mg.capture.gltf_reader import list_gltf, read_gltf
from unstructured_mg.capture.hcap_reader import open_hcap, read_hcap
from unstructured_mg.capture.manifest import find_manifests, read_manifest
from unstructured_mg.capture.raw_mesh import RawMesh
from unstructured_mg.capture.scvv_reader import is_scvv, open_scvv, read_scvv
from unstructured_mg.capture.uvol_reader import is_uvol, is_uvol_1, open_uvol, read_uvol
from unstructured_mg.capture.vols_reader import open_vols, read_vols, vols_files

GLTF_SUFFIXES = (".glb", ".gltf")


@dataclass(frozen=True)
class Sequence:
    """A file of many frames: their numbers in order, how a frame is read, the rate it states, and what is wrong behind
    its last good frame.
    """

    path: Path
    format: str
    numbers: tuple[int, ...]
    fps: float | None
    fault: FrameError | None = None


_READERS: dict[str, Callable[[Path, Path, int], RawMesh]] = {
    "vols": read_vols,
    "gltf": read_gltf,
    "hcap": read_hcap,
    "uvol": read_uvol,
    "scvv": read_scvv,
}


def find_sequence(folder: Path, names: list[str], capture: Path) -> Sequence | None:
    """The sequence that the files of these names in ``folder`` are, None where they are frames each for itself.

    A folder is one sequence: a manifest, a vologram, or a single glTF file of several frames. ``capture`` is the whole
    capture's folder: nothing outside is touched.

    Raises
    ------
    FrameError : there is one that cannot be read, or there are two
    """
    found: list[Sequence] = []
    for path in find_manifests(folder, names):
        try:
            data = read_manifest(path)
        except FrameError:
            continue  # any program's: only what is seen to be a capture's can be held against it
        if is_uvol_1(data):
            raise FrameError(path, "it is UVOL 1 (Corto), which is not supported", "convert it to UVOL 2")
        if is_uvol(data):
            uvol = open_uvol(path)
            found.append(Sequence(path, "uvol", tuple(range(uvol.geometry.count)), uvol.geometry.fps))
        elif is_scvv(data):
            scvv = open_scvv(path)
            found.append(Sequence(path, "scvv", tuple(range(len(scvv.frames))), scvv.fps))
    for name in vols_files([name for name in names if name.lower().endswith(".vols")]):
        vols = open_vols(folder / name)
        numbers = tuple(frame.number for frame in vols.frames)
        found.append(Sequence(vols.path, "vols", numbers, vols.fps, vols.fault))
    scenes = [name for name in names if name.lower().endswith(GLTF_SUFFIXES)]
    if len(scenes) == 1 and not found:
        sequence = _gltf_sequence(folder / scenes[0], capture)
        found += [] if sequence is None else [sequence]
    if len(found) > 1:
        raise FrameError(
            found[1].path, f"{found[0].path.name} beside it is a whole capture too", "give each a folder of its own"
        )
    return found[0] if found else None


def read_part(path: Path, folder: Path, format: str, part: int) -> RawMesh:
    """Frame ``part``, by its position, of the sequence at ``path``. Raises FrameError as the reader of that format."""
    with malformed(path):
        return _READERS[format](path, folder, part)


def _gltf_sequence(path: Path, capture: Path) -> Sequence | None:
    with malformed(path):
        holovideo = open_hcap(path, capture)
        if holovideo is not None:
            return Sequence(path, "hcap", tuple(range(len(holovideo.keys))), holovideo.fps)
        frames = list_gltf(path, capture)
    return None if frames is None else Sequence(path, "gltf", frames.numbers, frames.fps)
