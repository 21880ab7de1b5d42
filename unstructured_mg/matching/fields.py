"""The descriptors' coefficients of all frames, on disk, frequency by frequency."""

from dataclasses import dataclass
from pathlib import Path

import numpy as np

# Frames in a file: enough for long reads, few enough for a worker's memory (67 MB at N = 64).
BLOCK = 32


@dataclass(frozen=True)
class Fields:
    """Two fields (left 0, right 1) of ``(frames, frequencies, cells) complex64``, in files of BLOCK frames.

    A file holds ``(field, frequency, frame, cell)``, so that one frequency of a file's frames is one read. Files are
    read and not mapped: mapped pages would count as memory in every worker.
    """

    folder: Path
    frames: int
    frequencies: int
    cells: int

    def blocks(self) -> list[range]:
        return [range(start, min(start + BLOCK, self.frames)) for start in range(0, self.frames, BLOCK)]

    def path(self, block: range) -> Path:
        return self.folder / f"fields_{block.start:06d}.complex64"

    def write(self, block: range, fields: np.ndarray) -> None:
        """Write ``(2, frequencies, len(block), cells) complex64``."""
        fields.tofile(self.path(block))

    def read(self, field: int, frequency: int, start: int, stop: int) -> np.ndarray:
        """``(stop - start, cells) complex64``: one frequency of frames ``start .. stop - 1``."""
        rows = np.empty((stop - start, self.cells), np.complex64)
        for block in self.blocks()[start // BLOCK : (stop - 1) // BLOCK + 1]:
            first, last = max(start, block.start), min(stop, block.stop)
            row = (field * self.frequencies + frequency) * len(block) + first - block.start
            with open(self.path(block), "rb", buffering=0) as file:
                file.seek(8 * row * self.cells)
                target = rows[first - start : last - start]
                if file.readinto(target.view(np.uint8)) != target.nbytes:  # type: ignore[arg-type]
                    raise ValueError(f"{self.path(block)}: expected {target.nbytes} bytes at row {row}, got fewer")
        return rows

    def remove(self) -> None:
        for block in self.blocks():
            self.path(block).unlink(missing_ok=True)
