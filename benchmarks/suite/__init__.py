"""The benchmark: one module a part, each with ``measure(repeats) -> list[Row]``; `make bench`."""
