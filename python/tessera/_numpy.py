"""numpy, imported by calls that take or give arrays. ImportError names its package."""
try:
    import numpy as numpy
except ModuleNotFoundError as error:
    raise ImportError("numpy: not installed; expected Debian's package python3-numpy, as this call takes "
                      "or gives arrays", name="numpy") from error
