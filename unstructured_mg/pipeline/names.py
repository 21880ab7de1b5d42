"""Names of artefacts in the work folder."""

from unstructured_mg.capture.capture import Capture


def frame_name(capture: Capture, index: int) -> str:
    """A frame's id as a file name: a colon is not allowed in one everywhere."""
    return capture.frame_id(index).replace(":", "_")


def pair_name(capture: Capture, source: int, target: int, group: str = "pairs") -> str:
    """``GROUP/<s>-<t>``: "cages" and "pairs" have one artefact a pair, "transitions" and "pictures" one a direction."""
    return f"{group}/{frame_name(capture, source)}-{frame_name(capture, target)}"
