"""Sections, tables and drawings of the chapter on the mesh phase."""
