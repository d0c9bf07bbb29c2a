"""Numbers as colours, curves, pictures and HTML."""
