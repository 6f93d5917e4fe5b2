"""Supplied equations compared with themselves and with the engines."""
