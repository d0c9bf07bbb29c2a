"""From a folded map to a certified one: the repair, its parts, and the paper's Algorithm 2."""
