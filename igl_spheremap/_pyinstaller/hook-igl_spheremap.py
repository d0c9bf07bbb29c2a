"""For PyInstaller: all modules, since public names are imported at their first use, and what pages are made of."""

from PyInstaller.utils.hooks import collect_data_files, collect_submodules

hiddenimports = collect_submodules("igl_spheremap")
datas = collect_data_files("igl_spheremap")
