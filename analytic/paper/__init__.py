"""The paper's equations as printed: one module for each group."""
