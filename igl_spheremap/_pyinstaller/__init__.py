"""The folder of PyInstaller's hook, by the entry point in pyproject.toml."""


def folders() -> list[str]:
    """The folder of the hook."""
    return list(__path__)
