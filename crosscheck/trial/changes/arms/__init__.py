"""Changes of an arm's terms, and of steps of its derivation, that explain wrong entries."""
