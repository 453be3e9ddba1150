"""Adds to what is built, and to an editable install, what is made from the models of the language."""

import sys
from pathlib import Path

from setuptools import setup
from setuptools.command.build_py import build_py

ROOT = Path(__file__).parent


class BuildWithMadeFiles(build_py):
    """Builds the modules, and writes beside them what is made from these."""

    def run(self) -> None:
        """Write into the folder of the build; of an editable install, that is the checkout."""
        super().run()
        sys.path.insert(0, str(ROOT))  # a build has no other way to the package
        from stackdsl.built_files import write_built_files  # noqa: PLC0415 -- as above

        write_built_files((ROOT if self.editable_mode else Path(self.build_lib)) / "stackdsl")


setup(cmdclass={"build_py": BuildWithMadeFiles})
