"""StackDSL: checks scenarios of stacked bricks by proofs of statics, simulation and golden files."""

from time import time

from stability.process_settings import ask_for_one_thread

ask_for_one_thread(unless_set=True)  # before numpy is imported

LOADED = time()  # [s] since 1970; this process does not run code that is written later
