"""Separate bodies on revolute joints with contacts found from their poses."""
