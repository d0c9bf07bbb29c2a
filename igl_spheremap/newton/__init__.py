"""Second-order minimisation over maps: systems with two unknowns a vertex, and one damped loop of Newton steps."""
