"""What hits, pushes, pulls out or slides in: from what an author writes to where and when it begins.

One module a kind; importing this package registers them all.
"""

from stackdsl.compiling.impacts import drops as drops
from stackdsl.compiling.impacts import handling as handling
from stackdsl.compiling.impacts import pushes as pushes
from stackdsl.compiling.impacts import removals as removals
from stackdsl.compiling.impacts import throws as throws
