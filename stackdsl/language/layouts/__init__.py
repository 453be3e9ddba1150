"""Layouts, one module for each. Importing this package registers all of them."""

from stackdsl.language.layouts import arch as arch
from stackdsl.language.layouts import card_house as card_house
from stackdsl.language.layouts import column as column
from stackdsl.language.layouts import corbel as corbel
from stackdsl.language.layouts import dominoes as dominoes
from stackdsl.language.layouts import flat_arch as flat_arch
from stackdsl.language.layouts import four_stack as four_stack
from stackdsl.language.layouts import harmonic as harmonic
from stackdsl.language.layouts import jenga as jenga
from stackdsl.language.layouts import leaning_structure as leaning_structure
from stackdsl.language.layouts import pyramid as pyramid
from stackdsl.language.layouts import ring as ring
from stackdsl.language.layouts import tower as tower
from stackdsl.language.layouts import wall as wall
