"""Cross-checks on record, and what has changed since."""
