"""Which systems take part. One on another engine joins by being listed here: a System whose settings open its world."""

from collections.abc import Mapping

from stackdsl.playing.systems import SYSTEMS, System

ENTRANTS: Mapping[str, System] = SYSTEMS  # by name
# Bare engines that a converged reference may be taken from, the most trusted first.
REFERENCES = ("tuned", "stock")
