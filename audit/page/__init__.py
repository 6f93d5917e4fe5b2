"""The page of the audit: its chapters, tables and texts."""
