"""A user's own equations of a robot: do they agree, and if not, which number explains it?"""
