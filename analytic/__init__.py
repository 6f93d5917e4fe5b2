"""The paper's dynamics, equation by equation, in the paper's coordinates."""
