"""Analyses of proven assemblies: margins, orders of building, repairs, uniqueness of rest."""
