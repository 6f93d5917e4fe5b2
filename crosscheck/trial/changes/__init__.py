"""Changes that explain a difference: of a term, of a derivation's step, of the arm's numbers."""
