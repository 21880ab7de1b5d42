"""Walks with fewer faces a frame: one connectivity stays one."""

import hashlib
from collections.abc import Iterable, Iterator
from dataclasses import replace

import numpy as np

from unstructured_mg.capture.capture import Capture
from unstructured_mg.capture.decimated import apply_decimation
from unstructured_mg.capture.mesh import TexturedMesh
from unstructured_mg.geometry.decimate import Decimation, decimate
from unstructured_mg.playback.stream import LoadTransition, PosedFrame
from unstructured_mg.synthesis.texture_flow import TextureFlow
from unstructured_mg.synthesis.transition import Transition

# Steps of a transition that its decimation must serve: its ends, its middle and two between.
POSES = 5


def decimated_frames(frames: Iterable[PosedFrame], capture: Capture, goal: int) -> Iterator[PosedFrame]:
    """Captured frames with about ``goal`` faces; synthesized ones pass as they are (see `decimated_transitions`).

    Frames of the same connectivity and uvs lose the same vertices, those that the first of them in ``frames`` can
    spare, so that a capture of constant connectivity keeps it. Only hashes are remembered of the connectivities seen.
    """
    first: dict[bytes, int] = {}
    recent: tuple[bytes, Decimation] | None = None
    for frame in frames:
        if frame.origin.frame is None or len(frame.faces) <= goal:
            yield frame
            continue
        mesh = TexturedMesh(
            frame.own_vertices, frame.faces, frame.uv, frame.face_uv, frame.colors, (), frame.face_material
        )
        key = _connectivity(mesh)
        if recent is None or recent[0] != key:
            index = first.setdefault(key, frame.origin.frame)
            base = mesh if index == frame.origin.frame else capture.read(index)
            recent = key, decimate(base.vertices, base.faces, goal, base.uv, base.face_uv, base.face_material)
        small = apply_decimation(mesh, recent[1])
        yield replace(
            frame,
            own_vertices=small.vertices,
            faces=small.faces,
            uv=small.uv,
            face_uv=small.face_uv,
            colors=small.colors,
            face_material=small.face_material,
        )


def decimated_transitions(load_transition: LoadTransition, goal: int) -> LoadTransition:
    """The same transitions with about ``goal`` faces, the same ones in all steps."""

    def load(source: int, target: int) -> Transition:
        return decimated_transition(load_transition(source, target), goal)

    return load


def decimated_transition(transition: Transition, goal: int) -> Transition:
    """A transition with about ``goal`` faces on the same textures; as it is where it has no more."""
    if len(transition.faces) <= goal:
        return transition
    steps = np.unique(np.linspace(0, len(transition.vertices) - 1, POSES).round().astype(int))
    found = decimate(transition.vertices[steps], transition.faces, goal, transition.uv, transition.face_uv)
    return replace(
        transition,
        vertices=transition.vertices[:, found.vertex_index],
        faces=found.faces,
        uv=transition.uv[found.uv_index],
        face_uv=found.face_uv,
        colors=None if transition.colors is None else transition.colors[:, found.vertex_index],
        flow=None if transition.flow is None else _kept_flow(transition.flow, found),
    )


def _kept_flow(flow: TextureFlow, found: Decimation) -> TextureFlow:
    return replace(
        flow,
        reference=flow.reference[found.vertex_index],
        displacement=flow.displacement[found.vertex_index],
        uv_flow=flow.uv_flow[found.uv_index] if len(flow.uv_flow) else flow.uv_flow,
        colors=None if flow.colors is None else flow.colors[:, found.vertex_index],
    )


def _connectivity(mesh: TexturedMesh) -> bytes:
    digest = hashlib.blake2b(digest_size=16)
    for array in (mesh.faces, mesh.uv, mesh.face_uv, mesh.face_material):
        digest.update(b"/" if array is None else array.tobytes())
    return digest.digest()
