"""The paper's equations and text on trial."""
