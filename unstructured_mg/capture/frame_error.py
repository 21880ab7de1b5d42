"""What is wrong with one frame's files."""

from pathlib import Path

from unstructured_mg.errors import UserError


class FrameError(UserError):
    """A file of a frame cannot be used: the ``file``, the ``fault`` in it and the ``remedy``."""

    def __init__(self, file: Path, fault: str, remedy: str) -> None:
        super().__init__(f"{file}: {fault}; {remedy}.")
        self.file = file
        self.fault = fault
        self.remedy = remedy

    def __reduce__(self) -> tuple[type["FrameError"], tuple[Path, str, str]]:
        return FrameError, (self.file, self.fault, self.remedy)
