"""Lagrange's equations of geared planar arms, derived once, in symbols or numbers."""
