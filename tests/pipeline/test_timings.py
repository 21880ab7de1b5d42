from unstructured_mg.pipeline.timings import Timings


def test_figures_survive_a_restart_and_are_summed_by_group(tmp_path):
    timings = Timings(tmp_path / "timings.json")
    timings.items.update({"pairs/1-2": 3.0, "pairs/4-9": 4.0, "cages/1-2": 5.0})
    with timings.wall("reading"):
        pass
    timings.save()
    again = Timings(tmp_path / "timings.json")
    assert again.stages == timings.stages and set(again.stages) == {"reading"}
    assert again.total("pairs") == 7.0
    assert again.total("pairs", ["pairs/4-9"]) == 4.0
