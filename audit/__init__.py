"""The paper on trial: its equations, figures and conclusions."""
