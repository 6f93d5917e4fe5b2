"""Three planets counted as one, on trial (hypothesis H7)."""
