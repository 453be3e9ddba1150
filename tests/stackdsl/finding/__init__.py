"""Tests of the limits that are found, and of what margins depend on."""
