"""A capture of meshes in memory, and a simple figure to fill it with."""

from pathlib import Path

import numpy as np
import trimesh
from toy_capture import ToyCapture

from unstructured_mg.capture.capture import FrameFile
from unstructured_mg.capture.mesh import TexturedMesh


def array_capture(meshes=(), fps=30.0, clips=None):
    """Frames from (vertices, faces) pairs, or none; ``clips`` are (name, numbers) in playing order."""
    clips = clips or [("clip", range(len(meshes)))]
    frames = tuple(
        FrameFile(name, number, Path(f"{name}/{number}.obj")) for name, numbers in clips for number in numbers
    )
    assert len(meshes) in (0, len(frames))
    read = tuple(TexturedMesh(*mesh) for mesh in meshes).__getitem__
    return ToyCapture(Path("arrays"), frames, fps, 1.0, "z", 0.0, mesh_of=read)


def figure(phase, yaw=0.0, position=(0.0, 0.0, 0.0), seed=None, level=3):
    """A 1.8 m figure with a nose, swinging its limbs once in ``phase`` 2 pi; every ``seed`` is another mesh.

    ``level`` 3, 4, 5: 9k, 36k, 143k faces.
    """
    rng = np.random.default_rng(seed)
    swing = 0.5 * np.sin(phase)
    vertices, faces, count = [], [], 0
    parts = [  # centre of the joint, half axes, angle about y, joint's place on the part
        ((0, 0, 1.15), (0.13, 0.19, 0.33), 0.0, 0.0),
        ((0, 0, 1.65), (0.11, 0.09, 0.14), 0.0, 0.0),
        ((0.12, 0, 1.63), (0.04, 0.03, 0.03), 0.0, 0.0),
        ((0, 0.24, 1.4), (0.05, 0.05, 0.32), swing, 1.0),
        ((0, -0.24, 1.4), (0.05, 0.05, 0.32), -swing - 0.6, 1.0),
        ((0, 0.1, 0.9), (0.08, 0.08, 0.45), -swing, 1.0),
        ((0, -0.1, 0.9), (0.08, 0.08, 0.45), swing, 1.0),
    ]
    for joint, axes, angle, hang in parts:
        ball = trimesh.creation.icosphere(level)
        points = ball.vertices @ trimesh.transformations.random_rotation_matrix(rng.random(3))[:3, :3].T
        points = points * axes - [0, 0, hang * axes[2]]
        c, s = np.cos(angle), np.sin(angle)
        vertices.append(points @ np.array([[c, 0, s], [0, 1, 0], [-s, 0, c]]).T + joint)
        faces.append(ball.faces + count)
        count += len(points)
    c, s = np.cos(yaw), np.sin(yaw)
    turned = np.concatenate(vertices) @ np.array([[c, -s, 0], [s, c, 0], [0, 0, 1]]).T
    return turned + np.asarray(position, float), np.concatenate(faces).astype(np.int32)
