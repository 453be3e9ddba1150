"""Imports sapien, for all other modules of the package."""

import warnings

__all__ = ["sapien"]

with warnings.catch_warnings():
    warnings.simplefilter("ignore")  # it searches a graphics driver, which is not needed here
    import sapien
