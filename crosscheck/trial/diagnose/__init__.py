"""Diagnosis of the wrong term in a wrong entry."""
