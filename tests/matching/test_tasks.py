from concurrent.futures import ThreadPoolExecutor
from time import sleep

from unstructured_mg.matching.tasks import run


def late(index, seconds):
    sleep(seconds)
    return index


def test_results_come_in_the_order_of_the_tasks():
    tasks = [(index, 0.01 * (index % 3 == 0)) for index in range(10)]
    with ThreadPoolExecutor(4) as pool:
        assert list(run(late, tasks, pool)) == list(run(late, tasks, None)) == list(range(10))
        assert list(run(late, [], pool)) == []
