"""Changes of a robot and of its derivation, tried as causes of a difference at all states."""
