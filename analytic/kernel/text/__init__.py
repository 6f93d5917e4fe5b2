"""The equations as the text of a kernel, for the structure of an arm."""
