"""Robots in MuJoCo's format, MJCF, as URDFs."""
