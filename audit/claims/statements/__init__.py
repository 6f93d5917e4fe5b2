"""The paper's claims as data, section by section."""
