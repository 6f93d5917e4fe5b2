"""The equations that a user supplies, loaded and called."""
