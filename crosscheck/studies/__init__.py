"""Sweeps and ensembles of simulations."""
