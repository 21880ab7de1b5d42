"""What is wrong with one frame's files."""

from collections.abc import Iterator
from contextlib import contextmanager
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


@contextmanager
def malformed(path: Path) -> Iterator[None]:
    """Around the reading of a JSON format: a value of the wrong kind anywhere in it becomes a FrameError.

    A file may hold a list where a name belongs, or text where a number does, at some hundred places; asking at each
    would say no more than this.
    """
    try:
        yield
    except (AttributeError, IndexError, KeyError, TypeError, ValueError, OverflowError) as error:
        raise FrameError(path, f"a value in it is not what belongs there ({error})", "export the file again") from error
