"""StackDSL: scenarios of stacked bricks, with impacts and claims, that are proven, played and locked."""

from time import time

from stability.process_settings import ask_for_one_thread

ask_for_one_thread(unless_set=True)  # before numpy is loaded

LOADED = time()  # [s] since 1970; this process does not run code that is written later
