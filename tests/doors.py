"""The public names of both front doors: those of `ism`, and those of `ism.shapes` as `shapes.NAME`."""

import igl_spheremap as ism

PUBLIC = {name: getattr(ism, name) for name in ism.__all__ if name != "shapes"}
PUBLIC |= {f"shapes.{name}": getattr(ism.shapes, name) for name in ism.shapes.__all__}
