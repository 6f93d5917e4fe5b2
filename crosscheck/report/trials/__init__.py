"""A trial in the terminal, as JSON, as a page and in a notebook."""
