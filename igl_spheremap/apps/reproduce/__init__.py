"""The paper's tables and figures, computed anew and set beside the paper's own numbers."""

#: Names of all tables and figures, and one for all of them.
ITEMS = ("table1", "table2", "table3", "fig3", "fig4", "fig5", "fig6", "fig9", "fig10")
ALL = "all"
