import numpy as np
import pytest
from toy_latent import curved_model

from unstructured_mg.errors import UserError
from unstructured_mg.synthesis.latent.files import model_bytes, read_model
from unstructured_mg.synthesis.latent.tensors import packed


def test_a_model_comes_back(tmp_path):
    model = curved_model()
    path = tmp_path / "model.safetensors"
    path.write_bytes(model_bytes(model))
    found = read_model(path)
    latents = np.random.default_rng(0).normal(size=(3, 3))
    np.testing.assert_allclose(found.decode(latents), model.decode(latents), atol=1e-5)
    np.testing.assert_array_equal(found.faces, model.faces)
    assert model_bytes(found) == path.read_bytes()


def test_damaged_files_name_themselves_and_the_remedy(tmp_path):
    whole = model_bytes(curved_model())
    path = tmp_path / "model.safetensors"
    header = int.from_bytes(whole[:8], "little") + 8
    damaged = [b"", whole[:-1], whole[:100], b"\xff" * 8 + whole[8:], b"pickle", whole[:header]]
    damaged.append(packed({"mean": np.zeros((2, 3))}, {"format": "1"}))
    damaged.append(packed({}, {"format": "2"}))
    for content in damaged:
        path.write_bytes(content)
        with pytest.raises(UserError, match=r"model\.safetensors: .*make it again"):
            read_model(path)


def test_faces_beyond_the_vertices_are_found(tmp_path):
    from dataclasses import replace

    path = tmp_path / "model.safetensors"
    path.write_bytes(model_bytes(replace(curved_model(), faces=np.array([[0, 1, 4]], np.int32))))
    with pytest.raises(UserError, match="its faces point beyond its vertices"):
        read_model(path)


def test_no_file(tmp_path):
    with pytest.raises(UserError, match="it cannot be read"):
        read_model(tmp_path / "nothing")
