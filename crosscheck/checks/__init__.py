"""Comparisons of models that know nothing but the common interface."""
