#!/usr/bin/env python3
"""The pictures of same_pixels_test.py by any number of workers with any number of threads and any tile size."""
import itertools
import unittest

import same_pixels_test


class EveryWay(same_pixels_test.SamePixels):
    workers_for_paths = same_pixels_test.WORKERS

    def combined(self, workers, threads, tiles):
        return list(itertools.product(workers, threads, tiles))


if __name__ == "__main__":
    unittest.main()
