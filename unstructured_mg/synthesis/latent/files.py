"""A latent model as a safetensors file."""

from pathlib import Path

import numpy as np

from unstructured_mg.errors import UserError
from unstructured_mg.synthesis.latent.model import LatentModel
from unstructured_mg.synthesis.latent.network import Network
from unstructured_mg.synthesis.latent.tensors import packed, unpacked

FORMAT = "1"


def model_bytes(model: LatentModel) -> bytes:
    """``model`` as the content of a file; weights as float32."""
    tensors = {"faces": model.faces, "mean": model.mean, "basis": model.basis}
    tensors["scale_and_ridge"] = np.array([model.scale, model.ridge])
    for name, network in (("encoder", model.encoder), ("decoder", model.decoder)):
        tensors[f"{name}.weight"] = network.weight.astype(np.float32)
        tensors[f"{name}.bias"] = network.bias.astype(np.float32)
        for layer, (weight, bias) in enumerate(network.layers):
            tensors[f"{name}.{layer}.weight"] = weight.astype(np.float32)
            tensors[f"{name}.{layer}.bias"] = bias.astype(np.float32)
    return packed(tensors, {"format": FORMAT, "program": "unstructured_mg"})


def read_model(path: Path) -> LatentModel:
    """Read a model. Raises UserError where the file is none, or where its arrays do not belong together."""
    try:
        content = path.read_bytes()
    except OSError as error:
        raise UserError(f"{path}: it cannot be read ({error.strerror}); make a model with umg learn.") from None
    tensors, notes = unpacked(content, str(path))
    if notes.get("format") != FORMAT:
        raise UserError(f"{path}: it was not written by this version of umg learn; make it again.")
    try:
        model = LatentModel(
            tensors["faces"],
            tensors["mean"],
            tensors["basis"],
            float(tensors["scale_and_ridge"][0]),
            _network(tensors, "encoder"),
            _network(tensors, "decoder"),
            float(tensors["scale_and_ridge"][1]),
        )
        fault = _fault(model)
    except (KeyError, IndexError, TypeError) as error:
        fault = f"the array {error} is missing or has the wrong shape"
    if fault:
        raise UserError(f"{path}: {fault}; make it again with umg learn.")
    return model


def _network(tensors: dict[str, np.ndarray], name: str) -> Network:
    layers: list[tuple[np.ndarray, np.ndarray]] = []
    while f"{name}.{len(layers)}.weight" in tensors:
        layer = f"{name}.{len(layers)}"
        layers.append((tensors[f"{layer}.weight"].astype(np.float64), tensors[f"{layer}.bias"].astype(np.float64)))
    weight, bias = tensors[f"{name}.weight"], tensors[f"{name}.bias"]
    return Network(weight.astype(np.float64), bias.astype(np.float64), tuple(layers))


def _fault(model: LatentModel) -> str:
    """What does not fit together, or nothing."""
    if model.mean.ndim != 2 or model.mean.shape[1] != 3 or model.faces.ndim != 2 or model.faces.shape[1] != 3:
        return "its mean or its faces are not three columns wide"
    if model.faces.size and not 0 <= model.faces.min() <= model.faces.max() < len(model.mean):
        return "its faces point beyond its vertices"
    if model.basis.ndim != 2 or model.basis.shape[1] != model.mean.size:
        return "its basis is not as wide as its mean"
    size = len(model.encoder.bias)
    for network, inputs, outputs in ((model.encoder, len(model.basis), size), (model.decoder, size, len(model.basis))):
        widths = [inputs]
        for weight, bias in network.layers:
            if weight.shape != (len(bias), widths[-1]):
                return "its layers do not follow each other"
            widths.append(len(bias))
        if network.weight.shape != (outputs, inputs) or widths[-1] not in (outputs, inputs):
            return "its networks do not fit its basis"
        if network.layers and widths[-1] != outputs:
            return "its networks do not fit its basis"
    numbers = [model.mean, model.basis, np.array([model.scale, model.ridge])]
    for network in (model.encoder, model.decoder):
        numbers += [network.weight, network.bias, *(part for layer in network.layers for part in layer)]
    return "" if all(np.isfinite(values).all() for values in numbers) else "it holds numbers that are not finite"
