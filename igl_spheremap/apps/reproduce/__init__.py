"""The paper's tables and figures, computed anew and set beside the paper's own numbers."""
