"""What many surfaces have in common: their template, their mean, their modes, and where groups of them differ."""
