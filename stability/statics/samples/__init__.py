"""Many assemblies alike but for small errors of placement, judged together: what one proof needs, all go through at once."""
