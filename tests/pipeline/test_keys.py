import hashlib

import pytest

from unstructured_mg.pipeline.keys import content_key, file_hash


def test_the_key_is_the_hash_of_sorted_json_without_spaces():
    """The rule of docs/files.md, by which others can compute it."""
    text = b'{"a":[1,2.5,null],"b":{"c":"x","d":true}}'
    expected = hashlib.sha256(text).hexdigest()
    assert content_key({"a": [1, 2.5, None], "b": {"c": "x", "d": True}}) == expected
    assert content_key({"b": {"d": True, "c": "x"}, "a": [1, 2.5, None]}) == expected


def test_other_inputs_have_another_key():
    inputs = [{"k": 10}, {"k": 11}, {"k": "10"}, {"k": 10.5}, {"k": [10]}, {"j": 10}, {"k": None}, {}]
    assert len({content_key(each) for each in inputs}) == len(inputs)
    with pytest.raises(ValueError):
        content_key({"k": float("nan")})


def test_a_file_is_hashed_by_its_bytes(tmp_path):
    content = bytes(range(256)) * 5000
    (tmp_path / "a.bin").write_bytes(content)
    assert file_hash(tmp_path / "a.bin") == hashlib.sha256(content).hexdigest()
