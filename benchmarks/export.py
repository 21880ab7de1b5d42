"""Exports: (a) frames a second and bytes a frame of every format, beside trimesh writing the same frames, (b) memory
for 2,000 distinct frames against 200, (c) decimation beside VTK's, which knows no uvs.

    python benchmarks/export.py [--quick] [--json FILE] [--formats obj glb ...]

(a) Frames of 10,000 faces with 1-Mpixel JPEG textures, another connectivity in every one, shown in turn at ever other
places, read and written by two workers. Frames a second are those of two cores that do nothing else: frames over the
larger of this process's processor seconds and half of all processes', start and end left out (the difference of a long
and a short run); so they hold on a busy machine too. trimesh is one process on one core and reads with our reader; it
encodes textures anew (OBJ, GLB) or leaves them out (PLY).
"""

import argparse
import json
import resource
import subprocess
import sys
import tempfile
import time
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
import pyvista
import trimesh
from PIL import Image

from unstructured_mg.capture.capture import Capture, FrameFile
from unstructured_mg.capture.mesh import TexturedMesh
from unstructured_mg.capture.procedural.write import write_procedural
from unstructured_mg.capture.reader import open_capture
from unstructured_mg.capture.texture import Texture
from unstructured_mg.geometry.closest import ClosestPoints
from unstructured_mg.geometry.decimate import decimate
from unstructured_mg.geometry.planar import PlanarRigid
from unstructured_mg.pipeline.pool import Pool
from unstructured_mg.playback.export import FORMATS, export_walk
from unstructured_mg.playback.export_options import ExportOptions
from unstructured_mg.playback.walk import Walk, WalkFrame, capture_walk

FACES, TEXTURE = 10000, 1024
REACH = {"obj": 20.0}  # frames a second; of all others:
OTHERS = 5.0
PEERS = ("obj", "ply", "glb")


@dataclass(frozen=True)
class Waves(Capture):
    """Sheets of 5,000 triangles, a texture and a connectivity each, in memory one at a time."""

    textures: str = ""

    def read(self, index: int) -> TexturedMesh:
        side = 50
        y, x = np.mgrid[: side + 1, : side + 1].reshape(2, -1) / side
        at = np.arange(side * (side + 1)).reshape(side, side + 1)[:, :side].ravel()
        faces = np.concatenate(
            [np.stack([at, at + 1, at + side + 2], 1), np.stack([at, at + side + 2, at + side + 1], 1)]
        )
        faces = np.roll(faces, index, axis=0).astype(np.int32)
        vertices = np.stack([x, 0.1 * np.sin(9 * x + 0.1 * index), y], 1)
        texture = Texture(Path(self.textures) / f"{index}.jpg")
        return TexturedMesh(vertices, faces, np.stack([x, y], 1), faces, textures=(texture,))


def waves(folder: Path, count: int) -> Waves:
    for index in range(count):
        Image.fromarray(np.full((64, 64, 3), (index % 256, index // 256, 99), np.uint8)).save(folder / f"{index}.jpg")
    frames = tuple(FrameFile("", index, folder / f"{index}.obj") for index in range(count))
    return Waves(folder, frames, 30.0, 1.0, "z", 0.0, textures=str(folder))


def processor() -> tuple[float, float]:
    """Seconds of this process, and of those that it has waited for."""
    return tuple(sum(resource.getrusage(who)[:2]) for who in (resource.RUSAGE_SELF, resource.RUSAGE_CHILDREN))  # type: ignore[return-value]


def turns(capture: Capture, count: int) -> Walk:
    """The capture's frames in turn, each time elsewhere."""
    frames = tuple(
        WalkFrame("capture", n % len(capture), None, None, PlanarRigid(0.1 * (n // len(capture)), 0.01 * n, 0.0))
        for n in range(count)
    )
    return Walk(frames, "capture", None, 0, None, None)


def speed(capture: Capture, name: str, few: int, many: int, folder: Path) -> tuple[float, float, float]:
    """Frames a second on two cores, wall frames a second, and bytes a frame."""
    export_walk(turns(capture, 1), capture, None, folder / f"{name}-first", ExportOptions(format=name))
    spent = []
    for count in (few, many):
        here, others = processor()
        began = time.perf_counter()
        with Pool(2) as pool:
            export_walk(turns(capture, count), capture, None, folder / f"{name}{count}", ExportOptions(format=name),
                        executor=pool.executor)  # fmt: skip
        wall = time.perf_counter() - began
        now_here, now_others = processor()
        spent.append((now_here - here, now_others - others, wall))
    main, workers, wall = np.subtract(spent[1], spent[0])
    size = sum(path.stat().st_size for path in (folder / f"{name}{many}").iterdir()) / many
    return (many - few) / max(main, (main + workers) / 2), (many - few) / wall, size


def peer_speed(capture: Capture, name: str, count: int, folder: Path) -> tuple[float, float]:
    """trimesh: frames a second of one core, and bytes a frame."""
    folder.mkdir()
    began = time.process_time()
    for index in range(count):
        mesh = capture.read(index % len(capture))
        corners = mesh.vertices[mesh.faces].reshape(-1, 3)
        with Image.open(mesh.textures[0].path) as image:
            visual = trimesh.visual.TextureVisuals(mesh.uv[mesh.face_uv].reshape(-1, 2), image=image.copy())
        made = trimesh.Trimesh(corners, np.arange(len(corners)).reshape(-1, 3), visual=visual, process=False)
        made.merge_vertices()
        inside = folder / str(index)
        inside.mkdir()
        made.export(inside / f"frame.{name}")
    seconds = time.process_time() - began
    return count / seconds, sum(path.stat().st_size for path in folder.rglob("*.*")) / count


def peak(name: str, count: int, folder: Path) -> None:
    """In a process of its own: export, and print the largest memory in MiB."""
    textures = folder / f"{name}-{count}-textures"
    textures.mkdir()
    capture = waves(textures, count)
    options = ExportOptions(format=name, **({"picture_height": 64} if name == "mp4" else {}))
    export_walk(capture_walk(capture), capture, None, folder / f"{name}-{count}", options)
    print(largest_memory())


def largest_memory() -> float:
    """MiB of this program. Where it is known: not of what the process was before it became this program."""
    status = Path("/proc/self/status")
    if status.exists():
        return (
            int(next(line for line in status.read_text().splitlines() if line.startswith("VmHWM")).split()[1]) / 2**10
        )
    return resource.getrusage(resource.RUSAGE_SELF).ru_maxrss / (2**20 if sys.platform == "darwin" else 2**10)


def measured_peak(name: str, count: int, folder: Path) -> float:
    command = [sys.executable, __file__, "--peak", name, str(count), str(folder)]
    return float(subprocess.run(command, capture_output=True, text=True, check=True).stdout)


def missed(vertices: np.ndarray, faces: np.ndarray, points: np.ndarray) -> np.ndarray:
    return np.sqrt(np.maximum(ClosestPoints(vertices, faces).query(points)[0], 0))


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--quick", action="store_true", help="few frames")
    parser.add_argument("--formats", nargs="*", default=list(FORMATS), choices=list(FORMATS))
    parser.add_argument("--json", type=Path, help="write the figures to this file")
    parser.add_argument("--peak", nargs=3, help=argparse.SUPPRESS)
    arguments = parser.parse_args()
    if arguments.peak:
        peak(arguments.peak[0], int(arguments.peak[1]), Path(arguments.peak[2]))
        return
    figures: list[dict[str, Any]] = []

    def add(name: str, value: float, unit: str, reach: float | None = None, most: bool = False) -> None:
        holds = None if reach is None else bool(value <= reach if most else value >= reach)
        figures.append({"name": name, "value": float(value), "unit": unit, "reach": reach, "holds": holds})
        print(f"{name}: {value:.4g} {unit} (reach {reach}, holds: {holds})", flush=True)

    distinct, few, many = (4, 4, 36) if arguments.quick else (24, 24, 264)
    with tempfile.TemporaryDirectory() as name:
        folder = Path(name)
        write_procedural(folder / "capture", frames=distinct, faces=FACES, texture_size=TEXTURE)
        capture = open_capture(folder / "capture", fps=30.0, unit="m", up="z", floor=0.0)
        for each in arguments.formats:
            ours, wall, size = speed(capture, each, few, many, folder)
            add(f"{each}, two cores", ours, "frames/s", REACH.get(each, OTHERS))
            add(f"{each}, by the clock", wall, "frames/s")
            add(f"{each}", size / 1e3, f"kB a frame, each of {distinct} frames shown {many // distinct} times")
            if each in ("glb", "usd"):
                add(f"{each}", size * many / distinct / 1e3, "kB a distinct frame")
            if each in PEERS:
                peer, peer_size = peer_speed(capture, each, 2 if arguments.quick else 10, folder / f"peer-{each}")
                add(f"{each}, trimesh, one core", peer, "frames/s")
                add(f"{each}, trimesh", peer_size / 1e3, "kB a frame")
                add(f"{each}, times faster than trimesh, core for core", ours / 2 / peer, "x")
        mesh = capture.read(0)
        for goal in (5000, 2000):
            began = time.process_time()
            found = decimate(mesh.vertices, mesh.faces, goal, mesh.uv, mesh.face_uv)
            seconds = time.process_time() - began
            whole = pyvista.PolyData.from_regular_faces(mesh.vertices, mesh.faces)
            began = time.process_time()
            peer_mesh = whole.decimate(1 - goal / len(mesh.faces))
            peer_seconds = time.process_time() - began
            away = missed(mesh.vertices[found.vertex_index], found.faces, mesh.vertices)
            peer_faces = np.asarray(peer_mesh.regular_faces, np.int32)
            peer_away = missed(np.asarray(peer_mesh.points, np.float64), peer_faces, mesh.vertices)
            add(f"decimate {len(mesh.faces)} to {goal} faces, got", len(found.faces), "faces")
            add(f"decimate to {goal}", 1e3 * seconds, "ms")
            add(f"decimate to {goal}, VTK without uvs", 1e3 * peer_seconds, "ms")
            add(f"decimate to {goal}, mean distance missed", 1e3 * away.mean(), "mm")
            add(f"decimate to {goal}, mean distance missed, VTK without uvs", 1e3 * peer_away.mean(), "mm")
    short, long = (20, 80) if arguments.quick else (200, 2000)
    for each in ("glb", "usd") if arguments.quick else arguments.formats:
        with tempfile.TemporaryDirectory() as name:
            less, more = (measured_peak(each, count, Path(name)) for count in (short, long))
        add(f"{each}, memory at {short} frames", less, "MiB")
        add(f"{each}, memory at {long} frames over {short}", more / less, "x", 1.1, most=True)
    if arguments.json:
        arguments.json.write_text(json.dumps(figures, indent=1) + "\n")


if __name__ == "__main__":
    main()
