"""A trial of a user's equations of a robot: which number explains what is wrong?"""
