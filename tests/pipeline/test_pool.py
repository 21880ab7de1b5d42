import os

from unstructured_mg.pipeline.pool import SINGLE_THREAD, Pool


def thread_variables():
    return {name: os.environ.get(name) for name in SINGLE_THREAD}


def test_workers_have_one_blas_thread_and_a_dead_one_can_be_replaced():
    with Pool(1) as pool:
        assert pool.submit(thread_variables).result() == SINGLE_THREAD
        broken = pool.submit(os._exit, 3)
        assert broken.exception() is not None
        pool.restart()
        assert pool.submit(os.getpid).result() != os.getpid()
