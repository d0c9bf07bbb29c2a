"""The paper's tables and figures, computed anew and set beside the paper's own numbers."""

from .items import ITEMS, reproduce

__all__ = ["ITEMS", "reproduce"]
