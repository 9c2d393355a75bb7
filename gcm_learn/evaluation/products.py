"""Script that prints how long passes of ten products of matrices take [ms of processor time]."""

import sys
from time import process_time

import numpy as np

WORK = 400  # side of the matrices


def product_time() -> float:
    """Return the processor time of ten products of matrices [ms]."""
    matrix = np.random.default_rng(0).random((WORK, WORK))
    since = process_time()
    for _ in range(10):
        matrix = matrix @ matrix / WORK
    return 1e3 * (process_time() - since)


if __name__ == "__main__":
    product_time()  # libraries are loaded now
    for _ in range(int(sys.argv[1])):
        print(product_time())
