"""The one file that imports sapien; the rest of the package has it from here."""

import warnings

__all__ = ["sapien"]

with warnings.catch_warnings():
    warnings.simplefilter("ignore")  # it looks for a graphics driver, which nothing here needs
    import sapien
