"""What measurements of a robot say of its links, rotors and friction."""
