"""The experiment as data: start, drive and duration, and the switches of the gear model."""
