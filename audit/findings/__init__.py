"""The page's beginning: what came out, and the words that it takes to say it."""
