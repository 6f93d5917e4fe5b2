"""What first principles say of an arm, from its data alone: no model is asked, none is judged."""
