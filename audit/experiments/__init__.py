"""The paper's experiments, each run from many starts and kept."""
