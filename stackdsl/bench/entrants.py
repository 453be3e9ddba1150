"""Which systems take part: our own, and those on other engines whose packages are installed."""

from collections.abc import Mapping

from stackdsl.playing.peers import PEERS
from stackdsl.playing.systems import SYSTEMS, System

ENTRANTS: Mapping[str, System] = SYSTEMS | {name: peer.system for name, peer in PEERS.items()}  # by name
# Bare engines that a converged reference may be taken from, the most trusted first.
REFERENCES = ("tuned", "stock")


def installed() -> tuple[str, ...]:
    """The names of those that can be played here."""
    return tuple(name for name in ENTRANTS if name not in PEERS or PEERS[name].installed)
