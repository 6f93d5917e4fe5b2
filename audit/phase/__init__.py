"""The audit of the phase law of Eqs. 8 and 14 (hypothesis H1)."""
