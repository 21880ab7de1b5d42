import numpy as np

from unstructured_mg.geometry.morton import morton_order


def test_a_shuffled_cube_of_points_comes_back_block_by_block():
    corner = np.stack(np.meshgrid(*[np.arange(4)] * 3, indexing="ij"), -1).reshape(-1, 3).astype(float)
    shuffled = corner[np.random.default_rng(0).permutation(64)]
    ordered = shuffled[morton_order(shuffled)]
    for level in (8, 32):
        # Every aligned run of 8 fills a 2x2x2 block, every half of the curve half of the cube.
        for block in ordered.reshape(-1, level, 3):
            assert len(np.unique(block, axis=0)) == level
            assert np.prod(np.ptp(block, axis=0) + 1) == level
