"""All of polyscope: a window with a map in it, and the same picture without a screen."""
