"""Estimates of a robot's links, rotors and friction from measurements."""
