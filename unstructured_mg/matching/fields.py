"""What describes the frames, on disk, row by row."""

from dataclasses import dataclass
from pathlib import Path

import numpy as np

# Frames in a file: enough for long reads, few enough for a worker's memory (67 MB at N = 64).
BLOCK = 32


@dataclass(frozen=True)
class Fields:
    """``rows`` x ``cells`` numbers of ``dtype`` for each of ``frames``, in files of BLOCK frames.

    A file holds ``(row, frame, cell)``, so that one row of a file's frames is one read. Files are read and not mapped:
    mapped pages would count as memory in every worker.
    """

    folder: Path
    frames: int
    rows: int
    cells: int
    dtype: type

    def blocks(self) -> list[range]:
        return [range(start, min(start + BLOCK, self.frames)) for start in range(0, self.frames, BLOCK)]

    def path(self, block: range) -> Path:
        return self.folder / f"fields_{block.start:06d}.bin"

    def write(self, block: range, values: np.ndarray) -> None:
        """Write ``(rows, len(block), cells)`` of ``dtype``."""
        values.tofile(self.path(block))

    def read(self, row: int, start: int, stop: int) -> np.ndarray:
        """``(stop - start, cells)``: one row of frames ``start .. stop - 1``; zeros for those outside the capture."""
        values: np.ndarray = np.zeros((stop - start, self.cells), self.dtype)
        for block in self.blocks()[max(start, 0) // BLOCK : max(stop - 1, 0) // BLOCK + 1]:
            first, last = max(start, block.start), min(stop, block.stop)
            at = row * len(block) + first - block.start
            with open(self.path(block), "rb", buffering=0) as file:
                file.seek(values.itemsize * at * self.cells)
                target = values[first - start : last - start]
                if file.readinto(target.view(np.uint8)) != target.nbytes:  # type: ignore[arg-type]
                    raise ValueError(f"{self.path(block)}: expected {target.nbytes} bytes at row {at}, got fewer")
        return values

    def remove(self) -> None:
        for block in self.blocks():
            self.path(block).unlink(missing_ok=True)
