"""Impacts: one module a kind, which says what is written; importing this package registers them all.

They register in this order, which is that of the keys in the JSON Schema. What each comes to is in `compiling/impacts`.
"""

# isort: off
from stackdsl.language.impacts import remove as remove
from stackdsl.language.impacts import insert as insert
from stackdsl.language.impacts import throw as throw
from stackdsl.language.impacts import push as push
from stackdsl.language.impacts import drop as drop
from stackdsl.language.impacts import move as move
from stackdsl.language.impacts import hold as hold
