"""Batches of members: run here or on a cluster, kept, gathered into a result."""
