"""`python -m stackdsl` is `stackdsl`."""

from stackdsl.cli import main

main()
