"""Texture synthesis: (a) a warped picture on a plane against cross-fade and flat optical flow, (b) colours moved by a
known tangential field over a sphere and over the crane, (c) a captured middle frame left out of a window and
synthesized, with the time that a transition's 19 textures take.

    UMG_CAPTURES=FOLDER python benchmarks/texture.py [--quick] [--json FILE] [--work FOLDER ...] [--pictures FOLDER]

The crane is left out without UMG_CAPTURES; (c) needs WORK folders of ``umg build`` (their tracked pairs are used) and
writes one picture each into PICTURES (start, left-out frame, end; cross-fade, flow, what they differ by). Timings are
of one core.
"""

import argparse
import dataclasses
import io
import json
import os
import sys
import time
from pathlib import Path

import numpy as np
import scipy.ndimage as nd
from PIL import Image as PillowImage

sys.path.insert(0, str(Path(__file__).resolve().parents[1] / "tests"))
from real_captures import real_capture

from unstructured_mg.geometry.tracing import TracingSurface
from unstructured_mg.synthesis.advect import advect_images
from unstructured_mg.synthesis.flow import FlowSolver
from unstructured_mg.synthesis.flow_surface import build_flow_surface
from unstructured_mg.synthesis.images import spline_through
from unstructured_mg.synthesis.project import smooth_normals
from unstructured_mg.synthesis.signals import vertex_signals
from unstructured_mg.synthesis.texels import locate_texels
from unstructured_mg.synthesis.texture_options import TextureOptions

# Pixels at the picture's rim, where the warp brings in what neither end shows.
RIM = 20


def picture(size: int) -> np.ndarray:
    """A photograph where scikit-image is installed, else noise with such a spectrum: (size, size, 3) float64."""
    try:
        from skimage.data import astronaut
    except ImportError:
        generator = np.random.default_rng(0)
        frequency = np.hypot(*np.meshgrid(np.fft.fftfreq(size), np.fft.fftfreq(size)))
        frequency[0, 0] = 1
        noise = generator.normal(size=(3, size, size))
        image = np.fft.ifft2(np.fft.fft2(noise) / frequency**1.3).real.transpose(1, 2, 0)
        return (128 + 50 * (image - image.mean()) / image.std()).clip(0, 255)
    image = astronaut().astype(np.float64)
    return nd.zoom(image, (size / image.shape[0], size / image.shape[1], 1), order=1)


def warped(image: np.ndarray, shift: np.ndarray) -> np.ndarray:
    """``image(p + shift(p))``; shift (h, w, 2) in pixels, x then y."""
    row, column = np.mgrid[: image.shape[0], : image.shape[1]].astype(np.float64)
    place = [row + shift[:, :, 1], column + shift[:, :, 0]]
    return np.stack([nd.map_coordinates(image[:, :, c], place, order=3, mode="reflect") for c in range(3)], axis=-1)


def psnr(one: np.ndarray, other: np.ndarray) -> float:
    inner = np.s_[RIM:-RIM, RIM:-RIM]
    return float(10 * np.log10(255**2 / np.mean((np.asarray(one, np.float64)[inner] - other[inner]) ** 2)))


def plane(size: int, amplitude: float) -> list[dict]:
    """The middle of two pictures warped half way each; the truth is the picture itself."""
    image = picture(size)
    generator = np.random.default_rng(1)
    warp = np.stack(
        [nd.gaussian_filter(generator.normal(size=(size, size)), size / 8.5, mode="wrap") for _ in range(2)], axis=-1
    )
    warp *= amplitude / np.linalg.norm(warp, axis=2).max()
    start, end = warped(image, warp / 2).clip(0, 255), warped(image, -warp / 2).clip(0, 255)
    cells = size // 16
    x, y = np.meshgrid(np.linspace(0, size, cells + 1), np.linspace(0, size, cells + 1))
    vertices = np.stack([x.ravel(), y.ravel(), np.zeros(x.size)], axis=1)
    i = np.arange(x.size).reshape(x.shape)
    a, b, c, d = i[:-1, :-1].ravel(), i[:-1, 1:].ravel(), i[1:, 1:].ravel(), i[1:, :-1].ravel()
    faces = np.concatenate([np.stack([a, b, c], 1), np.stack([a, c, d], 1)]).astype(np.int32)
    options = TextureOptions()
    surface = build_flow_surface(vertices, faces, vertices[faces][:, :, :2] / size, options.edge_length)
    texels = locate_texels(surface, size, size, options.margin)
    everywhere = np.ones(len(texels.index), bool)
    signals = [vertex_signals(surface, texels, e.reshape(-1, 3)[texels.index], everywhere)[0] for e in (start, end)]
    began = time.process_time()
    normals = smooth_normals(surface.vertices, surface.tracing.faces)
    solver = FlowSolver(surface.vertices, normals, surface.tracing)
    flow = solver.estimate(*signals, options)
    seconds = time.process_time() - began
    splines = [
        spline_through(np.concatenate([e, np.ones((size, size, 1))], axis=2).astype(np.float32)) for e in (start, end)
    ]
    middle = advect_images(surface, texels, flow.corners, *splines, 1)[0]
    field = np.einsum("na,nac->nc", flow.field, solver.fields.axes)[:, :2] * (1, -1)
    place = [size - surface.vertices[:, 1] - 0.5, surface.vertices[:, 0] - 0.5]
    truth = np.stack([nd.map_coordinates(warp[:, :, c], place, order=1, mode="nearest") for c in range(2)], axis=1)
    inner = (np.abs(surface.vertices[:, :2] - size / 2) < size / 2 - RIM).all(axis=1)
    error = np.linalg.norm(field - truth, axis=1)[inner].mean()
    name = f"plane {amplitude:g} px"
    # The reach is for a picture of 512 pixels.
    reach = 39.0 if amplitude == 8 and size == 512 else None
    figures = [
        figure(f"{name}: PSNR, flow", psnr(middle, image), "dB", reach),
        figure(f"{name}: PSNR, cross-fade", psnr((start + end) / 2, image), "dB"),
        figure(f"{name}: end-point error, flow", error, "px"),
        figure(f"{name}: flow, {len(surface.vertices)} vertices", seconds, "s", 5.0, least=False),
    ]
    return figures + flat_peers(name, start, end, image, warp)


def flat_peers(name: str, start: np.ndarray, end: np.ndarray, image: np.ndarray, warp: np.ndarray) -> list[dict]:
    """scikit-image's flows, each end warped half way along and averaged."""
    try:
        from skimage.registration import optical_flow_ilk, optical_flow_tvl1
    except ImportError:
        return []
    figures = []
    for peer, method in (("TV-L1", optical_flow_tvl1), ("ILK", optical_flow_ilk)):
        began = time.process_time()
        there = method(start.mean(axis=2) / 255, end.mean(axis=2) / 255)
        seconds = time.process_time() - began
        shift = there[::-1].transpose(1, 2, 0)
        middle = 0.5 * (warped(start, -shift / 2) + warped(end, shift / 2))
        error = np.linalg.norm(shift - warp, axis=2)[RIM:-RIM, RIM:-RIM].mean()
        figures += [
            figure(f"{name}: PSNR, {peer}", psnr(middle, image), "dB"),
            figure(f"{name}: end-point error, {peer}", error, "px"),
            figure(f"{name}: {peer}", seconds, "s"),
        ]
    return figures


def sphere(subdivisions: int) -> list[dict]:
    """A pattern turned by 0.1 about the axis of a unit sphere: a flow that no plane holds."""
    import trimesh

    mesh = trimesh.creation.icosphere(subdivisions=subdivisions)
    vertices, faces = np.asarray(mesh.vertices), mesh.faces.astype(np.int32)
    generator = np.random.default_rng(0)
    waves = generator.normal(size=(40, 3)) * generator.uniform(3, 25, (40, 1))
    phase, tint = generator.uniform(0, 2 * np.pi, 40), generator.uniform(-0.3, 1, (40, 3))
    angle = 0.1

    def painted(turn: float) -> np.ndarray:
        c, s = np.cos(turn), np.sin(turn)
        points = vertices @ np.array([[c, -s, 0], [s, c, 0], [0, 0, 1.0]]).T
        return 128 + 12 * np.sin(points @ waves.T + phase) @ tint

    solver = FlowSolver(vertices, smooth_normals(vertices, faces), TracingSurface(vertices, faces))
    began = time.process_time()
    flow = solver.estimate(painted(angle / 2), painted(-angle / 2), TextureOptions())
    seconds = time.process_time() - began
    truth = angle * np.cross([0, 0, 1.0], vertices)
    error = np.linalg.norm(np.einsum("na,nac->nc", flow.field, solver.fields.axes) - truth, axis=1).mean()
    name = f"sphere, {len(vertices)} vertices"
    return [
        figure(f"{name}: end-point error / turn", error / angle, ""),
        figure(f"{name}: residual after / before", flow.residual_after / flow.residual_before, ""),
        figure(f"{name}: flow", seconds, "s"),
    ]


def crane() -> list[dict]:
    """Colours at the crane's vertices, moved both ways along a field that is known everywhere on the surface."""
    import trimesh

    (file,) = real_capture("mit_crane", ":", "--npz").glob("*.npz")
    with np.load(file) as arrays:
        mesh = trimesh.Trimesh(arrays["vertices"][0].astype(np.float64), arrays["faces"], process=False)
    diagonal = float(np.linalg.norm(np.ptp(mesh.vertices, axis=0)))
    vertices, faces = trimesh.remesh.subdivide_to_size(mesh.vertices, mesh.faces, 0.006 * diagonal)
    faces = np.ascontiguousarray(faces, np.int32)
    tracing = TracingSurface(vertices, faces)
    solver = FlowSolver(vertices, smooth_normals(vertices, faces), tracing)
    # A gentle swirl in space, as much of it as lies in the surface: at most 1.5 % of the diagonal.
    place = vertices / diagonal
    swirl = np.stack([np.sin(7 * place[:, 1]), np.cos(5 * place[:, 2]), np.sin(6 * place[:, 0] + 1)], axis=1)
    truth = np.einsum("nac,nc->na", solver.fields.axes, swirl)
    truth *= 0.015 * diagonal / np.linalg.norm(truth, axis=1).max()
    corners = solver.fields.at_corners(truth, faces)
    generator = np.random.default_rng(0)
    waves = generator.normal(size=(40, 3)) * generator.uniform(10, 120, (40, 1)) / diagonal
    phase, tint = generator.uniform(0, 2 * np.pi, 40), generator.uniform(-0.3, 1, (40, 3))

    def painted(time_along: float) -> np.ndarray:
        face, weights = (x[-1] for x in solver.paths(corners, time_along, 8))
        points = np.einsum("pi,pic->pc", weights, vertices[faces[face]])
        return 128 + 12 * np.sin(points @ waves.T + phase) @ tint

    start, end = painted(0.5), painted(-0.5)
    began = time.process_time()
    flow = solver.estimate(start, end, TextureOptions())
    seconds = time.process_time() - began
    error = np.linalg.norm(flow.field - truth, axis=1)
    name = f"crane, {len(vertices)} vertices"
    moved = float(solver.masses @ np.linalg.norm(truth, axis=1))
    return [
        figure(f"{name}: end-point error / motion", float(solver.masses @ error) / moved, ""),
        figure(f"{name}: residual after / before", flow.residual_after / flow.residual_before, ""),
        figure(f"{name}: flow", seconds, "s"),
    ]


def left_out(work: Path, most: int, pictures: Path | None) -> list[dict]:
    """Windows of tracked pairs: their middle frame synthesized from their ends, against the captured one."""
    from unstructured_mg.capture.capture import Capture
    from unstructured_mg.synthesis.texture import build_texture_surface, gradient_energy, synthesize_textures
    from unstructured_mg.tracking.files import read_pair

    capture = Capture.from_json(json.loads((work / "capture.json").read_text()))
    rows: dict[str, list[list[float]]] = {"flow": [], "crossfade": []}
    shapes: list[tuple[int, int]] = []
    for folder in sorted((work / "pairs").glob("*/tracked.npz"))[:most]:
        pair = read_pair(folder.parent)
        prepared = build_texture_surface(capture, pair, TextureOptions())
        if prepared.texels is None or prepared.atlas is None:
            return []
        inside = np.zeros((prepared.atlas.height, prepared.atlas.width), bool)
        inside.reshape(-1)[prepared.texels.index[prepared.texels.inside]] = True
        for first in (0, 2 * pair.k + 1):
            still = TextureOptions(method="crossfade", quality=100)
            middle = first + pair.k
            shown = synthesize_textures(capture, pair, middle, middle, 1, still, prepared)
            truth = pixels(shown.textures[0])
            strip = {}
            for method, found in rows.items():
                options = dataclasses.replace(TextureOptions(), method=method)
                began = time.process_time()
                blend = synthesize_textures(capture, pair, first, first + 2 * pair.k, 2 * pair.k - 1, options, prepared)
                seconds = time.process_time() - began
                made = pixels(blend.textures[pair.k - 1])
                strip[method] = made
                found.append(
                    [
                        blend.measures["sharpness"],
                        histogram_distance(made[inside], truth[inside]),
                        float(np.abs(made - truth)[inside].mean()),
                        gradient_energy(made, inside) / gradient_energy(truth, inside),
                        structural_similarity(made, truth, inside),
                        seconds,
                    ]
                )
            shapes.append(truth.shape[:2])
            if pictures is not None and blend.flow is not None:
                ends = [pixels(image) for image in blend.flow.textures]
                difference = 128 + 2 * (strip["flow"] - strip["crossfade"])
                sheet = np.concatenate(
                    [
                        np.concatenate([ends[0], truth, ends[1]], axis=1),
                        np.concatenate([strip["crossfade"], strip["flow"], difference], axis=1),
                    ]
                )
                pictures.mkdir(parents=True, exist_ok=True)
                name = f"{work.name}_{folder.parent.name}_{first}.png"
                PillowImage.fromarray(sheet.clip(0, 255).astype(np.uint8)).save(pictures / name)
    figures = []
    size = " x ".join(str(number) for number in shapes[0])
    names = ("sharpness against the ends", "histogram distance", "colour error", "sharpness against the truth")
    names = (*names, "structural similarity", f"textures of {2 * pair.k - 1} steps, {size}")
    fade = dict(zip(names, np.mean(rows["crossfade"], axis=0), strict=True))
    for method, found in rows.items():
        for what, value, unit in zip(names, np.mean(found, axis=0), ("", "levels", "levels", "", "", "s"), strict=True):
            name = f"{work.name}, {len(found)} windows: {what}, {method}"
            # Sharpness and a colour error below the cross-fade's only count together.
            if method == "flow" and what == names[0]:
                figures.append(figure(name, value, unit, 0.9))
            elif method == "flow" and what == "colour error":
                figures.append(figure(name, value, unit, fade[what], least=False))
            elif method == "flow" and what == names[-1] and max(shapes[0]) <= 1024:
                figures.append(figure(name, value, unit, 6.0, least=False))
            else:
                figures.append(figure(name, value, unit))
    return figures


def structural_similarity(one: np.ndarray, other: np.ndarray, inside: np.ndarray) -> float:
    """SSIM (Wang et al. 2004, doi 10.1109/TIP.2003.819861) of grey images over Gaussians of 1.5 pixels, in charts."""
    x, y = one.mean(axis=2), other.mean(axis=2)

    def mean(values: np.ndarray) -> np.ndarray:
        return nd.gaussian_filter(values, 1.5)

    u, v = mean(x), mean(y)
    spread, joint = mean(x * x) - u * u + mean(y * y) - v * v, mean(x * y) - u * v
    low, high = (0.01 * 255) ** 2, (0.03 * 255) ** 2
    found = (2 * u * v + low) * (2 * joint + high) / ((u * u + v * v + low) * (spread + high))
    return float(found[inside].mean())


def pixels(data: bytes) -> np.ndarray:
    return np.asarray(PillowImage.open(io.BytesIO(data)).convert("RGB")).astype(np.float64)


def histogram_distance(one: np.ndarray, other: np.ndarray) -> float:
    """Earth mover's distance of the channels' histograms (p, 3), in grey levels."""
    distances = []
    for c in range(3):
        both = [np.bincount(x[:, c].astype(int), minlength=256) / len(x) for x in (one, other)]
        distances.append(np.abs(np.cumsum(both[0] - both[1])).sum())
    return float(np.mean(distances))


def figure(name: str, value: float, unit: str, reach: float | None = None, least: bool = True) -> dict:
    value = float(value)
    holds = None if reach is None else bool(value >= reach if least else value <= reach)
    return {"name": name, "value": value, "unit": unit, "reach": reach, "holds": holds}


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--quick", action="store_true", help="smaller pictures, fewer windows: under a minute")
    parser.add_argument("--json", type=Path, help="write the figures here")
    parser.add_argument("--pictures", type=Path, help="write the pictures of (c) here")
    parser.add_argument("--work", type=Path, nargs="*", default=[], help="work folders of umg build, for (c)")
    arguments = parser.parse_args()
    figures = []
    size = 256 if arguments.quick else 512
    for amplitude in (3, 8):
        figures += plane(size, amplitude)
    figures += sphere(5 if arguments.quick else 6)
    if "UMG_CAPTURES" in os.environ:
        figures += crane()
    for work in arguments.work:
        figures += left_out(work, 1 if arguments.quick else 10, arguments.pictures)
    width = max(len(f["name"]) for f in figures)
    for f in figures:
        verdict = "" if f["reach"] is None else f"  reach {f['reach']:g}: {'holds' if f['holds'] else 'MISSED'}"
        print(f"{f['name']:{width}}  {f['value']:8.3f} {f['unit']}{verdict}")
    if arguments.json:
        arguments.json.write_text(json.dumps(figures, indent=1))


if __name__ == "__main__":
    main()
