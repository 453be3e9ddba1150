"""Many assemblies alike but for small errors of placement, judged together: one way of proving, checked for each."""
