"""Every statement of the paper, judged."""
