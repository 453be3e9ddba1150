"""Many cases and samples on one machine or many: a row each in a file, which a sweep that was ended goes on with."""
