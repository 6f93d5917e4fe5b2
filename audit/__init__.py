"""The audit of the paper: its equations, figures and conclusions."""
