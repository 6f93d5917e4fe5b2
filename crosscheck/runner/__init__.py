"""Work in other processes: tasks, workers, progress, and results that are kept."""
