"""Shared by all tests: single-threaded BLAS, as in the program's workers, and the rule that a skip is not a pass."""

import os

os.environ.setdefault("OPENBLAS_NUM_THREADS", "1")
os.environ.setdefault("OMP_NUM_THREADS", "1")


def pytest_sessionfinish(session, exitstatus):
    reporter = session.config.pluginmanager.get_plugin("terminalreporter")
    skipped = len(reporter.stats.get("skipped", []))
    if skipped and os.environ.get("UMG_FORBID_SKIPS"):
        reporter.write_line(f"{skipped} tests were skipped, and UMG_FORBID_SKIPS is set.", red=True)
        session.exitstatus = 1
