"""From a folded map to a certified one: progressive embedding, relaxation, and the order in which they are tried."""
