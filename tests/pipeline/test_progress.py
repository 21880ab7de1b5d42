import io

from rich.console import Console

from unstructured_mg.pipeline.progress import StageProgress


def test_a_file_gets_a_line_a_stage_and_no_bars():
    out = io.StringIO()
    progress = StageProgress(Console(file=out))
    with progress.stage("reading frames") as advance:
        for done in range(11):
            advance(done, 10)
    progress.note("pairs/1-2 was damaged and has been made again.")
    assert out.getvalue() == "reading frames ...\npairs/1-2 was damaged and has been made again.\n"


def test_a_terminal_gets_a_bar_that_counts():
    out = io.StringIO()
    with StageProgress(Console(file=out, force_terminal=True, width=120)).stage("reading frames") as advance:
        advance(3, 10)
        advance(10, 10)
    assert "reading frames" in out.getvalue() and "10/10" in out.getvalue()
