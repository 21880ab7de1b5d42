from unstructured_mg.pipeline.why import changes


def test_every_difference_is_told_and_nothing_else():
    before = {
        "k": 10,
        "tracking": {"cage": "lattice", "hausdorff_m": 0.1, "old": 1},
        "frames": ["a", "b", "c"],
        "up": "y",
    }
    now = {"k": 10, "tracking": {"cage": "tetwild", "hausdorff_m": 0.1}, "frames": ["a", "x", "y"], "up": "y", "yaw": 0}
    assert changes(before, now) == [
        "tracking.cage was lattice and is tetwild",
        "tracking.old is gone",
        "2 of 3 frames differ, the first is number 2",
        "yaw is new",
    ]
    assert changes(now, now) == []
    assert changes({"frames": ["a"]}, {"frames": []}) == ["frames were 1 and are 0"]
    assert changes({"a": "x" * 99}, {"a": None}) == [f"a was {'x' * 37}... and is None"]
