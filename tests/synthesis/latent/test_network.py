import numpy as np
import pytest
from toy_latent import random_network


@pytest.mark.parametrize("layers", [False, True])
def test_slopes_are_the_central_differences(layers):
    network = random_network(layers)
    x = np.random.default_rng(1).normal(size=(4, 3))
    value, slope = network.value_and_slope(x)
    np.testing.assert_array_equal(value, network(x))
    for axis in range(3):
        step = np.zeros(3)
        step[axis] = 1e-6
        difference = (network(x + step) - network(x - step)) / 2e-6
        np.testing.assert_allclose(slope[:, :, axis], difference, atol=1e-7)


def test_values_are_torchs():
    torch = pytest.importorskip("torch", reason="torch is not installed")
    network = random_network(True)
    x = np.random.default_rng(2).normal(size=(4, 3))
    modules = []
    for weight, bias in network.layers:
        linear = torch.nn.Linear(*weight.T.shape).double()
        linear.weight.data, linear.bias.data = torch.tensor(weight), torch.tensor(bias)
        modules += [linear, torch.nn.ELU()]
    expected = torch.nn.Sequential(*modules[:-1])(torch.tensor(x)).detach().numpy()
    np.testing.assert_allclose(network(x), x @ network.weight.T + network.bias + expected, atol=1e-12)
