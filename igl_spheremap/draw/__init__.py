"""How numbers look: colours, plots, tables as HTML."""
