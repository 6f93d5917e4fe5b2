"""Judging a paper by its claims: shares of starts, limits, verdicts. Knows no paper."""
