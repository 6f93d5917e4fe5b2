"""Views of one Agreement: terminal, page, figures."""
