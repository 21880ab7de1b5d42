"""What a build is compared by."""

from pathlib import Path


def contents(work: Path) -> dict[str, bytes]:
    """Every file's bytes but those that tell times, and those that the report makes."""
    files = {path.relative_to(work).as_posix(): path for path in work.rglob("*") if path.is_file()}
    skipped = ("timings.json", "lock", "report.html", "pictures/", "manifests/pictures/", "scratch/")
    return {name: path.read_bytes() for name, path in sorted(files.items()) if not name.startswith(skipped)}
