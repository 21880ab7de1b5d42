"""Where a build's tasks run: processes of this machine, or a Dask cluster."""

from unstructured_mg.pipeline.cluster import ClusterPool
from unstructured_mg.pipeline.pool import Pool


def open_pool(workers: int, address: str | None) -> Pool | ClusterPool:
    """``workers`` processes here, or where there is an ``address`` the workers of the Dask scheduler there."""
    return Pool(workers) if address is None else ClusterPool(address)
