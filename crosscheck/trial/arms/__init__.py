"""What an arm supplies to a trial: its models beside the equations, and its words."""
