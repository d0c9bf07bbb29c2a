"""From a folded map to a certified one: the repair and its parts."""
