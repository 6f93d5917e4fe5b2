"""The arm and the experiment as data, and each engine's model of them."""
