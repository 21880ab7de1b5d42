"""An export's folder: there complete, or not at all."""

import errno
import os
import re
import shutil
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path

from unstructured_mg.errors import UserError


@contextmanager
def whole_folder(out: Path, ours: str, force: bool) -> Iterator[Path]:
    """A folder beside ``out`` that becomes ``out`` when the block ends well, and vanishes when it does not.

    Parameters
    ----------
    ours : regular expression of the file names that an export writes
    force : replace ``out`` where all that it holds are such files

    Raises
    ------
    UserError
        Where ``out`` is a file or holds something that may not be replaced, and for what the operating system refuses.
    """
    out = Path(os.path.abspath(out))
    partial = out.with_name(f".{out.name}.{os.getpid()}.partial")
    try:
        _check_free(out, ours, force)
        partial.parent.mkdir(parents=True, exist_ok=True)
        shutil.rmtree(partial, ignore_errors=True)
        partial.mkdir()
        yield partial
        _check_free(out, ours, force)  # it may have been filled meanwhile
        _put(partial, out)
    except OSError as error:
        if error.errno in (errno.ENOSPC, getattr(errno, "EDQUOT", errno.ENOSPC)):
            fault = "the disk is full, and nothing was kept"
            remedy = "free some space or choose a folder on another disk"
        else:
            at = "" if error.filename is None or str(partial) in str(error.filename) else f" at {error.filename}"
            fault = f"the export failed{at} ({error.strerror or error}), and nothing was kept"
            remedy = "see to that or choose another folder"
        raise UserError(f"{out}: {fault}: {remedy}.") from error
    finally:
        shutil.rmtree(partial, ignore_errors=True)


def _put(partial: Path, out: Path) -> None:
    if not out.exists():
        partial.rename(out)
        return
    replaced = out.with_name(f".{out.name}.{os.getpid()}.replaced")
    out.rename(replaced)
    try:
        partial.rename(out)
    except BaseException:
        replaced.rename(out)
        raise
    shutil.rmtree(replaced)


def _check_free(out: Path, ours: str, force: bool) -> None:
    if not out.exists():
        return
    if not out.is_dir():
        raise UserError(f"{out}: this is a file, not a folder: choose another name.")
    names = sorted(path.name for path in out.iterdir())
    foreign = [name for name in names if not re.fullmatch(ours, name)]
    if names and not force:
        raise UserError(f"{out}: the folder is not empty: choose another, or replace an earlier export with --force.")
    if foreign:
        raise UserError(f"{out}: the folder holds {foreign[0]}, which no export wrote: choose another folder.")
