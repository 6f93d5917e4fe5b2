"""The arm as data: what its file holds, validated, and nothing derived from it."""
