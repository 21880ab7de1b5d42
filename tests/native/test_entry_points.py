"""Every compiled function against arguments that make no sense: an exception each time, never a crash.

What the functions compute is tested where they are used, and so is the validation of values (indices in range, finite
numbers). Here it is memory: wrong types, wrong lengths, arrays that are not contiguous or cannot be written. Run under
the sanitizers by ``make sanitize``.
"""

import re

import numpy as np
import pytest

from unstructured_mg import _native

FUNCTIONS = sorted(name for name in dir(_native) if not name.startswith("_"))

NONSENSE = {
    "none": None,
    "text": "vertices",
    "number": 3,
    "negative": -1,
    "huge": 2**62,
    "bytes": b"1234567",
    "empty": np.zeros((0, 3)),
    "short": np.zeros((1, 3)),
    "odd": np.zeros(7),
    "half": np.zeros((4, 3), np.float16),
    "complex": np.zeros((4, 3), np.complex128),
    "strided": np.zeros((8, 6))[::2, ::2],
    "backwards": np.zeros((4, 3))[::-1],
    "frozen": np.frombuffer(bytes(96)).reshape(4, 3),
    "shorts": np.zeros((4, 3), np.int16),
    "ints": np.zeros((5, 3), np.int32),
    "floats": np.zeros((5, 3), np.float32),
}

# Of these a function can make sense: an empty text has no vertices, no matrices have no rotations.
SENSIBLE = {("obj_count", "bytes"), ("fit_rotations", "empty"), ("vertex_components", "ints")}


def argument_count(function):
    """How many arguments a function takes, from what it says when it gets none."""
    try:
        function()
    except TypeError as error:
        found = re.search(r"(?:exactly|at least) (\w+) argument", str(error))
        return {"one": 1}.get(found[1]) or int(found[1]) if found else 1
    return 0


@pytest.mark.parametrize("name", FUNCTIONS)
@pytest.mark.parametrize("kind", NONSENSE)
def test_nonsense_in_every_place_is_refused(name, kind):
    function = getattr(_native, name)
    count = argument_count(function)
    if (name, kind) in SENSIBLE:
        function(*[NONSENSE[kind]] * count)
        return
    with pytest.raises((TypeError, ValueError, BufferError, OverflowError)):
        function(*[NONSENSE[kind]] * count)


@pytest.mark.parametrize("name", FUNCTIONS)
def test_mixed_nonsense_never_crashes(name):
    function = getattr(_native, name)
    count = argument_count(function)
    rng = np.random.default_rng(FUNCTIONS.index(name))
    kinds = list(NONSENSE.values())
    refused = 0
    for _ in range(300):
        arguments = [kinds[i] for i in rng.integers(len(kinds), size=count)]
        try:
            function(*arguments)
        except (TypeError, ValueError, BufferError, OverflowError, MemoryError):
            refused += 1
    assert refused > 250
