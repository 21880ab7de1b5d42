"""Motion graphs for unstructured textured meshes (after Prada, Kazhdan, Chuang, Collet and Hoppe 2016)."""

from importlib.metadata import PackageNotFoundError, version

try:
    __version__ = version("unstructured_mg")
except PackageNotFoundError:  # run from a source tree that was never installed
    __version__ = "0+source"
