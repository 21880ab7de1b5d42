"""Build of the compiled part: one C extension on CPython's limited API, so one wheel serves every Python from 3.11."""

import os
import sys
from pathlib import Path

from setuptools import Extension, setup

SANITIZE = ["-fsanitize=address,undefined", "-fno-omit-frame-pointer", "-g"] if os.environ.get("UMG_SANITIZE") else []
# No contraction of a*b+c and no fast-math: every vector path then rounds alike, and results repeat across processors.
COMPILE = (
    ["/O2", "/fp:precise"] if sys.platform == "win32" else ["-std=c11", "-O3", "-ffp-contract=off", "-Wall", "-Wextra"]
)

setup(
    ext_modules=[
        Extension(
            "unstructured_mg._native",
            sources=sorted(str(path) for path in Path("native").glob("*.c")),
            depends=sorted(str(path) for path in Path("native").glob("*.h")),
            define_macros=[("Py_LIMITED_API", "0x030B0000")],
            py_limited_api=True,
            extra_compile_args=COMPILE + SANITIZE,
            extra_link_args=SANITIZE,
        )
    ],
    options={"bdist_wheel": {"py_limited_api": "cp311"}},
)
