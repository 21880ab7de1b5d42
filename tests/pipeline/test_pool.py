import os
import signal
import subprocess
import sys
import time

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


def test_workers_end_when_their_parent_is_killed():
    script = "\n".join(
        [
            "import os, time",
            "from unstructured_mg.pipeline.pool import Pool",
            "if __name__ == '__main__':",
            "    pool = Pool(1)",
            "    print(pool.submit(os.getpid).result(), flush=True)",
            "    time.sleep(100)",
        ]
    )
    parent = subprocess.Popen([sys.executable, "-c", script], stdout=subprocess.PIPE, text=True)
    worker = int(parent.stdout.readline())
    parent.send_signal(signal.SIGKILL)
    parent.wait()
    parent.stdout.close()
    for _ in range(100):
        try:
            os.kill(worker, 0)
        except ProcessLookupError:
            return
        time.sleep(0.1)
    os.kill(worker, signal.SIGKILL)
    raise AssertionError("the worker outlived its parent by ten seconds")
