/* One line a kernel file: native/NAME.c defines `PyMethodDef umg_NAME_methods[]`. */
KERNEL(rotations)
KERNEL(obj)
KERNEL(weld)
KERNEL(edt)
KERNEL(correlation)
KERNEL(render)
KERNEL(chart_raster)
KERNEL(remesh)
