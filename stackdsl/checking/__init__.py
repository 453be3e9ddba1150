"""The pipeline of `stackdsl check`: which cases there are, and how each is played and judged, in processes."""
