"""The paper's Figures 4 to 20."""
