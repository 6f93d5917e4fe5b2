"""The phase law of Eqs. 8 and 14 on trial (hypothesis H1)."""
