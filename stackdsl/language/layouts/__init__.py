"""Named structures: one module a layout or a family of them; importing this package registers them all."""

from stackdsl.language.layouts import card_house, leaning_structure

__all__ = ["card_house", "leaning_structure"]
