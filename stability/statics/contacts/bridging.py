"""Does a gap between two bodies that are near each other count as contact? It depends on where it leads."""

from stability.geometry.touching import gap_bridged
from stability.statics.facts import Contact


def bridged(contact: Contact, gap: float, reach: float) -> Contact | None:
    """The contact, if a gap [m] as wide as this between its bodies counts with their reach [m]; else None."""
    upward = max(abs(normal[2]) for normal in contact.normals_W)
    return contact if gap <= gap_bridged(reach, upward) else None
