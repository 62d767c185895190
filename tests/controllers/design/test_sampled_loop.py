"""Products of polynomials of the sampled loop."""

import numpy as np


def test_product_of_polynomials_is_that_of_numpy():
    from controllers.design.sampled_loop import _product

    for first, second in (([0.0, 2.0, 1.0], [0.0, 0.0, 3.0]), ([0.0], [1.0, 2.0]), ([1.0, -1.0], [1.0, -1.0])):
        np.testing.assert_array_equal(_product(np.array(first), np.array(second)), np.polymul(first, second))
