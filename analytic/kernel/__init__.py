"""The equations of motion compiled for one structure of arm: a run alone, or many side by side."""
