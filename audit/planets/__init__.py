"""The audit of three planets counted as one (hypothesis H7)."""
