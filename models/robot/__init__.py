"""A robot as data: links and joints from a URDF, rotors from a file beside it."""
