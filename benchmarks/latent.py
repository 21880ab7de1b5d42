"""Latent models on frames they have not seen: R's variational autoencoder beside as many principal components.

Two blocks of 20 consecutive frames (40 to 59, 100 to 119) of each registered capture are held out. All models get the
same frames, on a common origin with the turn about the vertical taken out. Errors are distances of corresponding
vertices in percent of the first frame's diagonal: mean and largest over held-out frames, and the mean over seen ones.
Hausdorff is R's: the largest distance from a decoded held-out surface's vertices to the true surface. A file holds
mean, basis, networks and one code a frame, as float16. "same file" is the held-out error of the principal components
whose file is as large.
Mid-blends: as in blending.py, gap 16, volumetric ARAP and straight lines between latents side by side.

    UMG_CAPTURES=FOLDER python benchmarks/latent.py [--quick] [--json FILE]
"""

import argparse
import json
import sys
import time
from pathlib import Path

import igl
import numpy as np

sys.path.insert(0, str(Path(__file__).resolve().parents[1] / "tests"))
from blending import registered

from unstructured_mg.synthesis.latent.centre import centre_all, centre_on
from unstructured_mg.synthesis.latent.learn import learn
from unstructured_mg.synthesis.latent.model import LatentModel
from unstructured_mg.synthesis.latent.options import LatentOptions
from unstructured_mg.synthesis.latent.principal import principal_model

HELD = (range(40, 60), range(100, 120))
SIZES = (8, 16, 32, 64, 128)
# Held-out error at most this share of the principal components'.
SHARE, JUDGED = 0.7, (8, 16)
CAPTURES = ("mit_crane", "mit_samba", "mit_jumping")


def held_out(count: int) -> np.ndarray:
    mask = np.zeros(count, bool)
    for block in HELD:
        mask[block.start : block.stop] = True
    return mask


def distances(model: LatentModel, shapes: np.ndarray, diagonal: float) -> np.ndarray:
    """Distances of corresponding vertices, percent of the diagonal, (f, n)."""
    decoded = model.decode(model.encode(shapes))
    return 100 * np.linalg.norm(decoded - shapes, axis=2) / diagonal


def hausdorff(model: LatentModel, shapes: np.ndarray, diagonal: float) -> float:
    decoded = model.decode(model.encode(shapes))
    worst = 0.0
    for made, true in zip(decoded, shapes, strict=True):
        squared, _, _ = igl.point_mesh_squared_distance(made, true, model.faces.astype(np.int64))
        worst = max(worst, float(np.sqrt(squared.max())))
    return 100 * worst / diagonal


def file_bytes(model: LatentModel, frames: int) -> int:
    """Decoder, basis, mean and the codes of all frames, as float16."""
    numbers = model.mean.size + model.basis.size + model.decoder.weight.size + model.decoder.bias.size
    numbers += sum(weight.size + bias.size for weight, bias in model.decoder.layers) + frames * model.size
    return 2 * numbers


def components_of_size(size: int, n: int, frames: int) -> int:
    """How many principal components fill a file of ``size`` bytes."""
    return max(1, min((size // 2 - 3 * n) // (3 * n + frames), frames))


def measure(name: str, sizes: tuple[int, ...], epochs: int) -> list[dict]:
    surfaces, faces = registered(name)
    held = held_out(len(surfaces))
    diagonal = float(np.linalg.norm(np.ptp(surfaces[0], axis=0)))
    seen, mean = centre_all(surfaces[~held])
    unseen = np.stack([centre_on(frame, mean).shape for frame in surfaces[held]])
    whole = principal_model(seen, faces, len(seen))
    raw = 4 * surfaces[0].size * len(surfaces)
    print(f"\n{name}: {len(seen)} frames to learn from, {len(unseen)} held out, {surfaces.shape[1]} vertices")
    heads = ("model", "size", "mean", "max", "seen", "Hausd.", "MB", "raw/file", "same file", "dec/s", "CPU s")
    print("{:18} {:>4} {:>7} {:>7} {:>7} {:>7} {:>7} {:>8} {:>9} {:>7} {:>6}".format(*heads))
    figures = []

    def row(label: str, model: LatentModel, seconds: float) -> float:
        errors_held = distances(model, unseen, diagonal)
        size = file_bytes(model, len(surfaces))
        same = principal_model(seen, faces, components_of_size(size, len(mean), len(surfaces)))
        latents = model.encode(unseen, refine=False)
        begin = time.process_time()
        for latent in latents:
            model.decode(latent[None])
        rate = len(latents) / (time.process_time() - begin)
        values = (float(errors_held.mean()), float(errors_held.max()), float(distances(model, seen, diagonal).mean()))
        beside = float(distances(same, unseen, diagonal).mean())
        print(
            f"{label:18} {model.size:4} {values[0]:7.3f} {values[1]:7.2f} {values[2]:7.3f}"
            f" {hausdorff(model, unseen, diagonal):7.2f} {size / 1e6:7.2f} {raw / size:8.1f} {beside:9.3f}"
            f" {rate:7.0f} {seconds:6.0f}",
            flush=True,
        )
        figures.append(figure(f"{name}, {label}, {model.size}: decoded frames a second", rate, "1/s", 30, least=True))
        figures.append(figure(f"{name}, {label}, {model.size}: over raw float32", size / raw, "share", None))
        baseline = size / (128 * len(mean) * len(surfaces))
        figures.append(figure(f"{name}, {label}, {model.size}: over R's 128 bytes a vertex", baseline, "share", None))
        if label != "principal":
            title = f"{name}, {label}, {model.size}: held-out error over principal components' at the same file size"
            figures.append(figure(title, values[0] / beside, "ratio", 1.0))
        return values[0]

    for size in sizes:
        base = row("principal", principal_model(seen, faces, size), 0.0)
        for label, options in (
            ("variational", LatentOptions(size=size, epochs=epochs)),
            ("  no exchange", LatentOptions(size=size, epochs=epochs, exchanges=0)),
        ):
            begin = time.process_time()
            model = learn(surfaces[~held], faces, options)
            error = row(label, model, time.process_time() - begin)
            reach = SHARE if size in JUDGED and label == "variational" else None
            title = f"{name}, {label.strip()}, {size}: held-out error over principal components'"
            figures.append(figure(title, error / base, "ratio", reach))
    print(f"every component of the seen frames: {float(distances(whole, unseen, diagonal).mean()):.3f}")
    return figures


def figure(name: str, value: float, unit: str, reach: float | None, least: bool = False) -> dict:
    """One figure; smaller is better unless ``least``."""
    holds = None if reach is None else bool(value >= reach if least else value <= reach)
    return {"name": name, "value": float(value), "unit": unit, "reach": reach, "holds": holds}


def main() -> None:
    parser = argparse.ArgumentParser(description=(__doc__ or "").split("\n")[0])
    parser.add_argument("--quick", action="store_true", help="crane at 8 dimensions, few epochs: under a minute")
    parser.add_argument("--json", type=Path, help="write the figures to this file")
    arguments = parser.parse_args()
    captures, sizes, epochs = (CAPTURES[:1], SIZES[:1], 300) if arguments.quick else (CAPTURES, SIZES, 3000)
    figures = [figure for name in captures for figure in measure(name, sizes, epochs)]
    missed = [each["name"] for each in figures if each["holds"] is False]
    print("missed: " + ("; ".join(missed) or "nothing"))
    if arguments.json:
        arguments.json.write_text(json.dumps(figures, indent=2) + "\n")


if __name__ == "__main__":
    main()
